# cmake -DBUILD=folder -DWORK=folder -DEXAMPLE=a.cpp -DC_EXAMPLE=a.c -DOUTSIDE=folder
#       -DPACKAGE=a.beatlas -DMODEL=a.onnx -DPIPELINE=ON|OFF -P install_test.cmake
#
# Installs into a folder that is then moved, builds another project against it there, runs that
# project's programs and the installed ones. WORK must not lie in the sources: nothing may be found by
# a path of the build.
function(step what)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE out ERROR_VARIABLE out)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${what}: failed (${status})\n${out}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK})
step("installing" ${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/first)
file(RENAME ${WORK}/first ${WORK}/moved)
file(GLOB_RECURSE configs ${WORK}/moved/*.cmake)
foreach(config ${configs})
  file(READ ${config} text)
  if(text MATCHES "${BUILD}")
    message(FATAL_ERROR "${config} speaks of the build folder")
  endif()
endforeach()
step("configuring another project" ${CMAKE_COMMAND} -S ${OUTSIDE} -B ${WORK}/outside -G Ninja
     -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH=${WORK}/moved -DEXAMPLE=${EXAMPLE}
     -DC_EXAMPLE=${C_EXAMPLE} -DCMAKE_CXX_FLAGS=-Wall\ -Wextra\ -Werror)
step("building another project" ${CMAKE_COMMAND} --build ${WORK}/outside)
step("the README's example" ${WORK}/outside/touch ${PACKAGE})
step("the C example" ${WORK}/outside/touch_c ${PACKAGE})
step("the other rooms" ${WORK}/outside/rooms)
step("beatlas-play" ${WORK}/moved/bin/beatlas-play ${PACKAGE} --headless --seconds 0.1)
set(cohort ${WORK}/moved/share/beatlas/cohort)
foreach(file Snakefile README.md profiles/slurm/config.yaml profiles/kubernetes/config.yaml)
  if(NOT EXISTS ${cohort}/${file})
    message(FATAL_ERROR "${file} of the cohort is not installed")
  endif()
endforeach()
step("the cohort's tool" /usr/bin/python3 -B ${cohort}/cohort.py --help)
if(PIPELINE)
  if(EXISTS ${MODEL} AND NOT EXISTS ${WORK}/moved/share/beatlas/heart_prior.onnx)
    message(FATAL_ERROR "the prior's model is not installed")
  endif()
  step("beatlas" ${WORK}/moved/bin/beatlas info ${PACKAGE})
endif()
