#!/bin/sh
# Refuses an #include that points up the list of rooms, and an outside library outside the place that wraps it.
# usage: scripts/check_rooms.sh       (tests itself first, on planted includes)
set -eu
. "$(dirname "$0")/planted.sh"

# Prints FILE:LINE: reason for every offence under the current folder.
scan() {
  # shellcheck disable=SC2016
  find soa kernels integrators models solver scene recording cli python \( -name '*.hpp' -o -name '*.cpp' \) \
    2>/dev/null | sort | xargs awk '
    BEGIN {
      below["soa"] = "soa"
      below["kernels"] = "kernels"
      below["integrators"] = "integrators kernels"
      below["models"] = "models kernels soa"
      below["solver"] = "solver models integrators kernels soa"
      below["scene"] = "scene " below["solver"]
      below["recording"] = "recording " below["scene"]
      below["cli"] = "cli " below["recording"]
      below["python"] = "python " below["recording"]

      # Library -> the files that may include it.
      place["xsimd"] = "^kernels/lane[.]hpp$"
      place["sleef"] = "^kernels/math[.]hpp$"
      place["tbb"] = place["oneapi"] = "^solver/parallel[.]cpp$"
      place["Eigen"] = "[.]cpp$"  # other bits when vectorised: never in a header, never per instruction set
      place["toml"] = "^scene/"
      place["hdf5"] = place["H5"] = "^recording/"
      place["CLI"] = "^cli/"
    }
    /^[ \t]*#[ \t]*include[ \t]*"/ {
      split(FILENAME, path, "/")
      split($0, quoted, "\"")
      room = quoted[2]
      if (!sub(/\/.*/, "", room)) room = ""
      if (index(" " below[path[1]] " ", " " room " ") == 0 || room == "")
        print FILENAME ":" FNR ": \"" quoted[2] "\": " path[1] "/ may include ROOM/FILE of only: " below[path[1]]
    }
    /^[ \t]*#[ \t]*include[ \t]*</ {
      library = $0
      sub(/^[^<]*</, "", library)
      sub(/[^A-Za-z0-9_].*/, "", library)
      if (library in place && FILENAME !~ place[library])
        print FILENAME ":" FNR ": <" library "> is included only by files like " place[library]
    }' /dev/null
}

plant() {
  mkdir soa kernels integrators models solver scene recording cli
  cat >soa/planted.hpp <<'PLANTED'
#include <vector>
#include "soa/id.hpp"
#include "kernels/lane.hpp"  // BAD
#include "id.hpp"  // BAD
#include "../kernels/lane.hpp"  // BAD
PLANTED
  cat >kernels/planted.hpp <<'PLANTED'
#include "kernels/lane.hpp"
#include "soa/id.hpp"  // BAD
#include <xsimd/xsimd.hpp>  // BAD
# include <sleef.h>  // BAD
PLANTED
  printf '#include <xsimd/xsimd.hpp>\n' >kernels/lane.hpp
  cat >integrators/planted.hpp <<'PLANTED'
#include "kernels/lane.hpp"
#include "soa/id.hpp"  // BAD
#include "models/particle.hpp"  // BAD
PLANTED
  cat >models/planted.hpp <<'PLANTED'
#include "soa/id.hpp"
#include "integrators/euler.hpp"  // BAD
#include <Eigen/Dense>  // BAD
PLANTED
  cat >solver/planted.cpp <<'PLANTED'
#include "models/particle.hpp"
#include <Eigen/Dense>
#include <tbb/parallel_for.h>  // BAD
#include "scene/scene.hpp"  // BAD
PLANTED
  printf '#include <tbb/parallel_for.h>\n#include <oneapi/tbb.h>\n' >solver/parallel.cpp
  cat >scene/planted.cpp <<'PLANTED'
#include <toml++/toml.h>
#include "soa/id.hpp"
#include "recording/frame.hpp"  // BAD
#include <hdf5.h>  // BAD
PLANTED
  cat >recording/planted.cpp <<'PLANTED'
#include <hdf5.h>
#include "scene/scene.hpp"
#include <toml++/toml.h>  // BAD
#include "cli/run.hpp"  // BAD
PLANTED
  printf '#include "recording/frame.hpp"\n#include <CLI/CLI.hpp>\n' >cli/planted.cpp
}

check_lines
