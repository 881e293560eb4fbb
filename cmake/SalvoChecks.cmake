# The checks of the repository as tests, beside the tests of the library, so that one ctest sums up everything. The other
# compilers, minutes each, are tests of the configuration `legs` alone (ctest -C legs).
if(SALVO_SANITIZE OR NOT CMAKE_BUILD_TYPE STREQUAL "Release")
  return()  # once is enough, and the symbols are those of what is shipped
endif()

function(salvo_add_check name)
  add_test(NAME check.${name} COMMAND scripts/check_${name}.sh ${ARGN} WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
endfunction()
salvo_add_check(format)
salvo_add_check(rooms)
salvo_add_check(exact_set)
salvo_add_check(symbols ${PROJECT_BINARY_DIR})
salvo_add_check(tidy ${PROJECT_BINARY_DIR})
salvo_add_check(install ${PROJECT_BINARY_DIR})
set_tests_properties(check.tidy check.install PROPERTIES PROCESSORS 2 TIMEOUT 600 LABELS slow)

foreach(leg IN ITEMS clang-O3 clang-O0 gcc-O0 gcc-Og aarch64)
  add_test(NAME leg.${leg} COMMAND scripts/legs.sh ${leg} CONFIGURATIONS legs WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
  set_tests_properties(leg.${leg} PROPERTIES RUN_SERIAL TRUE TIMEOUT 900)
endforeach()
