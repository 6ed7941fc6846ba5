# A room is one folder, one library target beatlas::<name>, and one list of what it may use.
#
# beatlas_room(name SOURCES a.cpp ... [PUBLIC targets...] [PRIVATE targets...] [OWN_FLAGS] [AT_ONCE 6])
# OWN_FLAGS: a library that it uses changes the compiler's flags, so precompiled headers do not fit.
# AT_ONCE: so many files are compiled together; more where headers, and what they make, are most of it.

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  # Precompiled headers are compared by what they are made from.
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env
      CCACHE_SLOPPINESS=pch_defines,time_macros ${CCACHE_PROGRAM})
endif()

add_library(beatlas_flags INTERFACE)
target_include_directories(beatlas_flags INTERFACE ${CMAKE_SOURCE_DIR})
# No contraction: the same sums give the same bits whatever the compiler fuses.
target_compile_options(beatlas_flags INTERFACE -ffp-contract=off -Wall -Wextra -Wshadow
                                               -Wnon-virtual-dtor -Woverloaded-virtual)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # The compiler need not tidy its memory, which takes a tenth of its time, below what the largest files need in any
  # case [KiB]: a file of the runtime less than 0.6 GB, of the pipeline up to 5 GB (scripts/build_jobs counts with it).
  set(untidied_kib 262144)
  if(BEATLAS_PIPELINE)
    set(untidied_kib 1572864)
  endif()
  set(BEATLAS_UNTIDIED_KIB ${untidied_kib} CACHE STRING "Memory that the compiler need not tidy [KiB]")
  target_compile_options(beatlas_flags INTERFACE "SHELL:--param ggc-min-heapsize=${BEATLAS_UNTIDIED_KIB}")
endif()
if(BEATLAS_WERROR)
  target_compile_options(beatlas_flags INTERFACE -Werror)
endif()
if(BEATLAS_SANITIZE)
  # What is found ends the program, or a test in which undefined behaviour was found would pass.
  target_compile_options(beatlas_flags INTERFACE -fsanitize=${BEATLAS_SANITIZE}
                                                 -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(beatlas_flags INTERFACE -fsanitize=${BEATLAS_SANITIZE})
endif()

# What tests compute, rooms compute for them: tests are compiled with less optimisation, in half of the time.
# Precompiled headers hand on the optimisation that they were made with, whatever a file that uses them says.
add_library(beatlas_test_flags INTERFACE)
target_link_libraries(beatlas_test_flags INTERFACE beatlas_flags)
target_compile_options(beatlas_test_flags INTERFACE $<$<CONFIG:Release>:-O1>)

# Headers that nearly every file reads, precompiled once for rooms and once for their tests. Ours are never among them, and the presets dev, asan and
# tsan do without, so that every file still says what it includes.
option(BEATLAS_PCH "Precompile the headers of the standard library, Eigen, JSON and GoogleTest" ON)
set(BEATLAS_COMMON_HEADERS
    <algorithm> <array> <cmath> <cstdint> <filesystem> <fstream> <functional> <map> <memory>
    <optional> <span> <sstream> <string> <vector> <Eigen/Geometry> <nlohmann/json.hpp>)

# beatlas_precompiled(name HEADERS <a>... LINK targets...): what REUSE_FROM name stands for.
function(beatlas_precompiled name)
  cmake_parse_arguments(PCH "" "" "HEADERS;LINK" ${ARGN})
  file(WRITE ${CMAKE_BINARY_DIR}/${name}.cpp "")
  add_library(${name} OBJECT ${CMAKE_BINARY_DIR}/${name}.cpp)
  target_link_libraries(${name} PRIVATE ${PCH_LINK})
  target_precompile_headers(${name} PRIVATE ${PCH_HEADERS})
endfunction()

if(BEATLAS_PCH)
  if(CCACHE_PROGRAM AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    target_compile_options(beatlas_flags INTERFACE -fpch-preprocess)  # ccache reads what it leaves
  endif()
  find_package(Eigen3 REQUIRED NO_MODULE)
  find_package(nlohmann_json REQUIRED)
  beatlas_precompiled(beatlas_room_headers HEADERS ${BEATLAS_COMMON_HEADERS}
    LINK beatlas_flags Eigen3::Eigen nlohmann_json::nlohmann_json)
  set_target_properties(beatlas_room_headers PROPERTIES POSITION_INDEPENDENT_CODE ON)
endif()

function(beatlas_use_precompiled target headers)
  if(BEATLAS_PCH)
    target_precompile_headers(${target} REUSE_FROM ${headers})
  endif()
endfunction()

# Several files of a room are read at a time: their headers once, in half the time. So no two files of
# a room give their own things the same name; a file of tests that would has a namespace of its own.
# The presets dev, asan and tsan read each file alone.
option(BEATLAS_UNITY "Compile several files of a room at a time" ON)
function(beatlas_several_at_once target)
  set(count ${ARGN} 6)
  list(GET count 0 count)
  if(BEATLAS_UNITY)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${count})
  endif()
endfunction()

function(beatlas_room name)
  cmake_parse_arguments(ROOM "OWN_FLAGS" "AT_ONCE" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  add_library(beatlas_${name} STATIC ${ROOM_SOURCES})
  add_library(beatlas::${name} ALIAS beatlas_${name})
  set_target_properties(beatlas_${name} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  # An installed room brings its include folder itself and leaves warnings to its user.
  target_link_libraries(beatlas_${name} PUBLIC $<BUILD_INTERFACE:beatlas_flags> ${ROOM_PUBLIC}
                        PRIVATE ${ROOM_PRIVATE})
  target_compile_features(beatlas_${name} PUBLIC cxx_std_20)
  if(NOT ROOM_OWN_FLAGS)
    beatlas_use_precompiled(beatlas_${name} beatlas_room_headers)
  endif()
  beatlas_several_at_once(beatlas_${name} ${ROOM_AT_ONCE})
endfunction()

# beatlas_test(name SOURCES a_test.cpp ... LINK targets... [LABELS unit] [TIMEOUT s] [OWN_FLAGS]
#              [SHARE_FIXTURES])
# One GoogleTest program; each of its tests is one CTest test. SHARE_FIXTURES: the program is one, so
# that what its tests share (a made exam, a segmentation) is made once. None of them may be skipped: the
# whole would be counted as passed.
function(beatlas_test name)
  cmake_parse_arguments(TEST "OWN_FLAGS;SHARE_FIXTURES" "TIMEOUT" "SOURCES;LINK;LABELS" ${ARGN})
  if(NOT TEST_TIMEOUT)
    set(TEST_TIMEOUT 120)
  endif()
  if(NOT TEST_LABELS)
    set(TEST_LABELS unit)
  endif()
  add_executable(${name} ${TEST_SOURCES})
  target_link_libraries(${name} PRIVATE beatlas_test_flags ${TEST_LINK} GTest::gtest GTest::gtest_main)
  if(NOT TEST_OWN_FLAGS)
    beatlas_use_precompiled(${name} beatlas_test_headers)
  endif()
  beatlas_several_at_once(${name})
  if(TEST_SHARE_FIXTURES)
    add_test(NAME ${name} COMMAND ${name} --gtest_brief=1)
    # Many tests in one entry: begun first, it ends before the others do.
    set_tests_properties(${name} PROPERTIES LABELS "${TEST_LABELS}" TIMEOUT ${TEST_TIMEOUT}
                         COST 1000 FAIL_REGULAR_EXPRESSION "\\[  SKIPPED \\]")
  else()
    gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60 PROPERTIES
                         LABELS "${TEST_LABELS}" TIMEOUT ${TEST_TIMEOUT})
  endif()
endfunction()
