# cmake --install: programs, libbeatlas, and what a trainer compiles and links against, which it finds
# with find_package(beatlas_runtime), or the C interface with pkg-config (beatlas). cpack makes a Debian
# package of the same.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(BEATLAS_INCLUDES ${CMAKE_INSTALL_INCLUDEDIR}/beatlas)
set(BEATLAS_CONFIG ${CMAKE_INSTALL_LIBDIR}/cmake/beatlas_runtime)
set(BEATLAS_INTERNAL_ROOMS app viewer)  # of programs, not of the library

file(GLOB folders RELATIVE ${CMAKE_SOURCE_DIR}/runtime LIST_DIRECTORIES true
     ${CMAKE_SOURCE_DIR}/runtime/*)
foreach(folder ${folders})
  if(NOT EXISTS ${CMAKE_SOURCE_DIR}/runtime/${folder}/CMakeLists.txt)
    continue()
  endif()
  get_property(targets DIRECTORY ${CMAKE_SOURCE_DIR}/runtime/${folder}
               PROPERTY BUILDSYSTEM_TARGETS)
  foreach(target ${targets})
    get_target_property(type ${target} TYPE)
    if(type STREQUAL "EXECUTABLE" AND NOT target STREQUAL "beatlas_c_example")
      install(TARGETS ${target} RUNTIME)
    elseif(type MATCHES "^(STATIC|SHARED)_LIBRARY$" AND NOT folder IN_LIST BEATLAS_INTERNAL_ROOMS)
      # beatlas::runtime_atlas here and there.
      string(REGEX REPLACE "^beatlas_" "" name ${target})
      set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
      target_include_directories(${target} INTERFACE $<INSTALL_INTERFACE:${BEATLAS_INCLUDES}>)
      install(TARGETS ${target} EXPORT beatlas_runtime)
    endif()
  endforeach()
  if(NOT folder IN_LIST BEATLAS_INTERNAL_ROOMS)
    install(DIRECTORY ${CMAKE_SOURCE_DIR}/runtime/${folder}/
            DESTINATION ${BEATLAS_INCLUDES}/runtime/${folder} FILES_MATCHING PATTERN "*.h")
  endif()
endforeach()
if(TARGET beatlas)
  install(TARGETS beatlas RUNTIME)
endif()

install(EXPORT beatlas_runtime NAMESPACE beatlas:: FILE beatlas_runtime_targets.cmake
        DESTINATION ${BEATLAS_CONFIG})
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/beatlas_runtime-config.cmake.in
  ${CMAKE_BINARY_DIR}/beatlas_runtime-config.cmake INSTALL_DESTINATION ${BEATLAS_CONFIG})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/beatlas_runtime-config-version.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/beatlas_runtime-config.cmake
              ${CMAKE_BINARY_DIR}/beatlas_runtime-config-version.cmake
        DESTINATION ${BEATLAS_CONFIG})
# By its own place, so that what was installed may be moved.
set(BEATLAS_PKGCONFIG ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
file(RELATIVE_PATH BEATLAS_PREFIX_FROM_PC /${BEATLAS_PKGCONFIG} /)
configure_file(${CMAKE_CURRENT_LIST_DIR}/beatlas.pc.in ${CMAKE_BINARY_DIR}/beatlas.pc @ONLY)
install(FILES ${CMAKE_BINARY_DIR}/beatlas.pc DESTINATION ${BEATLAS_PKGCONFIG})
install(FILES ${CMAKE_SOURCE_DIR}/runtime/c/example.c DESTINATION ${CMAKE_INSTALL_DOCDIR}/examples)
install(DIRECTORY ${CMAKE_SOURCE_DIR}/samples ${CMAKE_SOURCE_DIR}/schemas
        DESTINATION ${CMAKE_INSTALL_DATADIR}/beatlas)
install(DIRECTORY ${CMAKE_SOURCE_DIR}/scripts/cohort DESTINATION ${CMAKE_INSTALL_DATADIR}/beatlas
        PATTERN "__pycache__" EXCLUDE)
# The prior's weights and what tells of them.
foreach(file heart_prior.onnx heart_prior.json)
  if(BEATLAS_PIPELINE AND EXISTS ${CMAKE_SOURCE_DIR}/pipeline/prior/${file})
    install(FILES ${CMAKE_SOURCE_DIR}/pipeline/prior/${file}
            DESTINATION ${CMAKE_INSTALL_DATADIR}/beatlas)
  endif()
endforeach()
install(FILES ${CMAKE_SOURCE_DIR}/README.md ${CMAKE_SOURCE_DIR}/LICENSE.md
        DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY ${CMAKE_SOURCE_DIR}/LICENSES ${CMAKE_SOURCE_DIR}/docs
        DESTINATION ${CMAKE_INSTALL_DOCDIR})

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME beatlas)
set(CPACK_PACKAGE_CONTACT "the authors of beatlas")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY ${PROJECT_DESCRIPTION})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS xvfb)  # pictures where there is no display
# What a trainer that links the static libraries needs besides.
set(CPACK_DEBIAN_PACKAGE_SUGGESTS
    "cmake, g++, libdraco-dev, libeigen3-dev, libssl-dev, libzip-dev, libzstd-dev, nlohmann-json3-dev")
include(CPack)
