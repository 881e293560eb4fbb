# Installs the library for find_package(salvo), its headers by room, the command and the scenes.
include(CMakePackageConfigHelpers)
set(salvo_package ${CMAKE_INSTALL_LIBDIR}/cmake/salvo)

set(salvo_libraries salvo salvo_headers salvo_flags)
if(TARGET salvo_recording)
  set_target_properties(salvo_recording PROPERTIES EXPORT_NAME recording)
  list(APPEND salvo_libraries salvo_recording)
endif()
install(TARGETS ${salvo_libraries} EXPORT salvo-targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT salvo-targets NAMESPACE salvo:: DESTINATION ${salvo_package})
foreach(room IN ITEMS soa kernels integrators models solver scene recording)
  if(NOT room STREQUAL "recording" OR SALVO_BUILD_RECORDING)
    install(DIRECTORY ${room}/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/salvo/${room} FILES_MATCHING PATTERN "*.hpp")
  endif()
endforeach()

configure_package_config_file(cmake/salvoConfig.cmake.in ${PROJECT_BINARY_DIR}/salvoConfig.cmake
  INSTALL_DESTINATION ${salvo_package} NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/salvoConfigVersion.cmake COMPATIBILITY SameMinorVersion)
# SalvoKernels: salvo_add_kernels() for a user's own models. SalvoFlags is not needed: its target is exported.
install(FILES ${PROJECT_BINARY_DIR}/salvoConfig.cmake ${PROJECT_BINARY_DIR}/salvoConfigVersion.cmake
  cmake/SalvoKernels.cmake cmake/FindSleef.cmake cmake/FindXxHash.cmake cmake/Findxsimd.cmake cmake/FindHDF5.cmake
  DESTINATION ${salvo_package})

if(TARGET salvo_cli)
  install(TARGETS salvo_cli)
  install(DIRECTORY scenes DESTINATION ${CMAKE_INSTALL_DATADIR}/salvo FILES_MATCHING PATTERN "*.toml" PATTERN "*.csv" PATTERN "*.obj")
endif()
