# cmake -DSOURCE=root -DBUILD=folder -DPYTHON=python3 -P runtime_builds_alone.cmake
#
# Configures the preset runtime-only, whose find_package knows none of the pipeline's libraries,
# builds it and holds the result to the law.
function(step what)
  execute_process(COMMAND ${ARGN} WORKING_DIRECTORY ${SOURCE} RESULT_VARIABLE status)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${what}: failed (${status})")
  endif()
endfunction()

file(READ ${SOURCE}/CMakePresets.json presets)
foreach(library VTK OpenCV OpenVDB CGAL OpenMesh)
  if(NOT presets MATCHES "CMAKE_DISABLE_FIND_PACKAGE_${library}\": \"ON")
    message(FATAL_ERROR "the preset runtime-only does not put ${library} out of reach")
  endif()
endforeach()
# Whether it builds does not hang on how well; the optimiser takes half of the time.
step("configuring" ${CMAKE_COMMAND} --preset runtime-only -DBEATLAS_TESTS=OFF
     -DCMAKE_CXX_FLAGS_RELEASE=-O0 -B ${BUILD} --fresh)
step("building" ${CMAKE_COMMAND} --build ${BUILD})
step("the compiler's log" ${PYTHON} tests/law/law.py --root ${SOURCE} compiled ${BUILD})
