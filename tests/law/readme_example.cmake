# The C++ example of the root README, compiled as it stands and run on the golden package.
if(TARGET beatlas::runtime_atlas AND TARGET beatlas::runtime_haptics)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/README.md)
  file(READ ${CMAKE_SOURCE_DIR}/README.md readme)
  string(FIND "${readme}" "```cpp\n" begin)
  string(SUBSTRING "${readme}" ${begin} -1 readme)
  string(SUBSTRING "${readme}" 7 -1 readme)
  string(FIND "${readme}" "```" end)
  string(SUBSTRING "${readme}" 0 ${end} example)
  set(source ${CMAKE_CURRENT_BINARY_DIR}/readme_example.cpp)
  file(CONFIGURE OUTPUT ${source} CONTENT "${example}" @ONLY)
  add_executable(readme_example ${source})
  target_link_libraries(readme_example PRIVATE beatlas_flags beatlas::runtime_atlas
                                               beatlas::runtime_haptics)
  law_test(readme_example_is_true TIMEOUT 60
           COMMAND readme_example ${CMAKE_SOURCE_DIR}/tests/package/golden/v3.beatlas)
endif()
