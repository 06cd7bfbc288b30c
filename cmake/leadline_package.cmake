# Installs the files that make find_package(leadline) work.
include(CMakePackageConfigHelpers)

set(package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/leadline")
configure_package_config_file("${PROJECT_SOURCE_DIR}/cmake/leadlineConfig.cmake.in"
  "${PROJECT_BINARY_DIR}/leadlineConfig.cmake"
  INSTALL_DESTINATION "${package_dir}")
write_basic_package_version_file("${PROJECT_BINARY_DIR}/leadlineConfigVersion.cmake"
  COMPATIBILITY SameMinorVersion)

install(EXPORT leadlineTargets NAMESPACE leadline:: DESTINATION "${package_dir}")
install(FILES
  "${PROJECT_BINARY_DIR}/leadlineConfig.cmake"
  "${PROJECT_BINARY_DIR}/leadlineConfigVersion.cmake"
  DESTINATION "${package_dir}")
