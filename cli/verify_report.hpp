// What salvo verify tells people: a table of hashes, and where the bits first differ if they do.
#pragma once

#include <string>

#include "cli/exit_status.hpp"
#include "scene/verify.hpp"

namespace salvo::cli {

/// `verified` is the scene at the size that was run.
std::string verify_report(const scene::Scene& scene, const scene::Scene& verified,
                          const scene::VerifyResult& result);

ExitStatus verify_status(const scene::VerifyResult& result);

}  // namespace salvo::cli
