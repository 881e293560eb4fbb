#include "recording/sealed_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <cerrno>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include "solver/state_hash.hpp"

namespace salvo::recording {

namespace {

constexpr std::string_view seal_label = "salvo xxh3-128 ";

std::string seal_of(const solver::Digest& digest) {
  return fmt::format("{}{}\n", seal_label, to_string(digest));
}

// A file being read. Every failure is a CorruptFile that names it.
class InputFile {
 public:
  explicit InputFile(const std::filesystem::path& path)
      : path_(path), descriptor_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
    if (descriptor_ < 0) fail(std::generic_category().message(errno));
  }
  ~InputFile() { ::close(descriptor_); }
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  std::size_t size() const {
    struct stat status {};
    if (::fstat(descriptor_, &status) != 0) fail(std::generic_category().message(errno));
    if (!S_ISREG(status.st_mode)) fail("it is not a regular file");
    return static_cast<std::size_t>(status.st_size);
  }
  void read(void* to, std::size_t size) const {
    auto* end = static_cast<std::byte*>(to);
    while (size != 0) {
      const ssize_t count = ::read(descriptor_, end, size);
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) fail(std::generic_category().message(errno));
      if (count == 0) fail("it ended while being read");
      end += count;
      size -= static_cast<std::size_t>(count);
    }
  }
  [[noreturn]] void fail(std::string_view reason) const {
    throw CorruptFile(fmt::format("cannot read {}: {}", path_.string(), reason));
  }

 private:
  std::filesystem::path path_;
  int descriptor_;
};

}  // namespace

void write_sealed(const std::filesystem::path& path, std::span<const std::byte> bytes,
                  Durability durability) {
  const std::string seal = seal_of(solver::digest_of(bytes.data(), bytes.size()));
  OutputFile file(path);
  file.write(bytes);
  file.write(seal);
  file.commit(durability);
}

void verify_seal(const std::filesystem::path& path) {
  constexpr std::size_t at_once = std::size_t{1} << 20;
  const InputFile file(path);
  const std::size_t size = file.size();
  const std::string truncated =
      "it is truncated or was changed: its last line is not a salvo checksum";
  if (size < seal_size) file.fail(truncated);

  const std::unique_ptr<XXH3_state_t, XXH_errorcode (*)(XXH3_state_t*)> state(XXH3_createState(),
                                                                              XXH3_freeState);
  XXH3_128bits_reset(state.get());
  std::vector<std::byte> buffer(at_once);
  for (std::size_t left = size - seal_size; left != 0;) {
    const std::size_t count = std::min(left, buffer.size());
    file.read(buffer.data(), count);
    XXH3_128bits_update(state.get(), buffer.data(), count);
    left -= count;
  }
  const XXH128_hash_t hash = XXH3_128bits_digest(state.get());
  const std::string actual = seal_of({hash.high64, hash.low64});

  std::string seal(seal_size, '\0');
  file.read(seal.data(), seal_size);
  if (!seal.starts_with(seal_label) || seal.back() != '\n') file.fail(truncated);
  if (seal != actual) {
    const auto digits = [](const std::string& line) {
      return line.substr(seal_label.size(), line.size() - seal_label.size() - 1);
    };
    file.fail(fmt::format("it was altered: its checksum is {}, its last line says {}",
                          digits(actual), digits(seal)));
  }
}

}  // namespace salvo::recording
