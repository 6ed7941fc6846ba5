# The C++ example of docs/trainer.md, compiled as it stands and run on the golden package.
if(TARGET beatlas::runtime_atlas AND TARGET beatlas::runtime_haptics)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/docs/trainer.md)
  file(READ ${CMAKE_SOURCE_DIR}/docs/trainer.md page)
  string(FIND "${page}" "```cpp\n" begin)
  string(SUBSTRING "${page}" ${begin} -1 page)
  string(SUBSTRING "${page}" 7 -1 page)
  string(FIND "${page}" "```" end)
  string(SUBSTRING "${page}" 0 ${end} example)
  set(source ${CMAKE_CURRENT_BINARY_DIR}/documented_example.cpp)
  file(CONFIGURE OUTPUT ${source} CONTENT "${example}" @ONLY)
  add_executable(documented_example ${source})
  target_link_libraries(documented_example PRIVATE beatlas_flags beatlas::runtime_atlas
                                               beatlas::runtime_haptics)
  law_test(documented_example_is_true TIMEOUT 60
           COMMAND documented_example ${CMAKE_SOURCE_DIR}/tests/package/golden/v3.beatlas)
endif()
