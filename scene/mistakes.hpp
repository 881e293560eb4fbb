// Where a scene's words stand, and the collection of everything that is wrong with them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace salvo::scene {

/// A stretch of a source. Source 0 is the file, source k the k-th override. Lines and columns count
/// from 1, in characters; line 0 is the source as a whole.
struct Place {
  int source = 0;
  int line = 0;
  int column = 0;
  int length = 0;
};

class Mistakes {
 public:
  Mistakes(std::string path, std::string_view text, std::vector<std::string> overrides);

  /// `problem` is one line; `hint` stands behind the carets.
  void add(const Place& place, std::string problem, std::string hint = {});
  std::size_t count() const { return mistakes_.size(); }
  /// In the order of the file, then of the overrides.
  std::vector<std::string> texts() const;

 private:
  struct Mistake {
    Place place;
    std::string problem;
    std::string hint;
  };

  std::string text_of(const Mistake& mistake) const;
  std::string_view line(const Place& place) const;

  std::string path_;
  std::vector<std::string_view> lines_;
  std::vector<std::string> overrides_;
  std::vector<Mistake> mistakes_;
};

}  // namespace salvo::scene
