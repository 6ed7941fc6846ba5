# What encode_field is made of; pipeline/pack/CMakeLists.txt lists these among its sources.
set(BEATLAS_FIELD_COEFFICIENTS_SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/distance_extension.cpp
    ${CMAKE_CURRENT_LIST_DIR}/field_coefficients.cpp
    ${CMAKE_CURRENT_LIST_DIR}/lattice.cpp
    ${CMAKE_CURRENT_LIST_DIR}/spline_prefilter.cpp)
