# The imported target xsimd, headers only. Debian's own package file also links xtl, which xsimd 8.1 does not need.
find_path(XSIMD_INCLUDE_DIR xsimd/xsimd.hpp)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(xsimd REQUIRED_VARS XSIMD_INCLUDE_DIR)
if(xsimd_FOUND AND NOT TARGET xsimd)
  add_library(xsimd INTERFACE IMPORTED)
  set_target_properties(xsimd PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${XSIMD_INCLUDE_DIR}")
endif()
