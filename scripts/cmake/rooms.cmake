# A room is one folder, one library target beatlas::<name>, and one list of what it may use.
#
# beatlas_room(name SOURCES a.cpp ... [PUBLIC targets...] [PRIVATE targets...])

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE_PROGRAM})
endif()

add_library(beatlas_flags INTERFACE)
target_include_directories(beatlas_flags INTERFACE ${CMAKE_SOURCE_DIR})
# No contraction: the same sums give the same bits whatever the compiler fuses.
target_compile_options(beatlas_flags INTERFACE -ffp-contract=off -Wall -Wextra -Wshadow
                                               -Wnon-virtual-dtor -Woverloaded-virtual)
if(BEATLAS_WERROR)
  target_compile_options(beatlas_flags INTERFACE -Werror)
endif()
if(BEATLAS_SANITIZE)
  target_compile_options(beatlas_flags INTERFACE -fsanitize=${BEATLAS_SANITIZE}
                                                 -fno-omit-frame-pointer)
  target_link_options(beatlas_flags INTERFACE -fsanitize=${BEATLAS_SANITIZE})
endif()

function(beatlas_room name)
  cmake_parse_arguments(ROOM "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  add_library(beatlas_${name} STATIC ${ROOM_SOURCES})
  add_library(beatlas::${name} ALIAS beatlas_${name})
  set_target_properties(beatlas_${name} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  target_link_libraries(beatlas_${name} PUBLIC beatlas_flags ${ROOM_PUBLIC} PRIVATE ${ROOM_PRIVATE})
endfunction()

# beatlas_test(name SOURCES a_test.cpp ... LINK targets... [LABELS unit] [TIMEOUT s])
# One GoogleTest program; each of its tests is one CTest test.
function(beatlas_test name)
  cmake_parse_arguments(TEST "" "TIMEOUT" "SOURCES;LINK;LABELS" ${ARGN})
  if(NOT TEST_TIMEOUT)
    set(TEST_TIMEOUT 120)
  endif()
  if(NOT TEST_LABELS)
    set(TEST_LABELS unit)
  endif()
  add_executable(${name} ${TEST_SOURCES})
  target_link_libraries(${name} PRIVATE beatlas_flags ${TEST_LINK} GTest::gtest GTest::gtest_main)
  gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60 PROPERTIES
                       LABELS "${TEST_LABELS}" TIMEOUT ${TEST_TIMEOUT})
endfunction()
