# cmake -DSOURCE=root -DBUILD=folder -DPYTHON=python3 -DUNTIDIED_KIB=n -P runtime_builds_alone.cmake
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
# As the tests' own build is compiled, and as deep below the root: where a file's command is the same without the
# pipeline, ccache has what it makes.
step("configuring" ${CMAKE_COMMAND} --preset runtime-only -DBEATLAS_TESTS=OFF
     -DBEATLAS_UNTIDIED_KIB=${UNTIDIED_KIB} -B ${BUILD} --fresh)
step("building" bash scripts/build_jobs ${CMAKE_COMMAND} --build ${BUILD})
step("the compiler's log" ${PYTHON} tests/law/law.py --root ${SOURCE} compiled ${BUILD})
