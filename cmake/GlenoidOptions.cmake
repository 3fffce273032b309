# Warnings, sanitizers and floating-point rules shared by every target of the project (linked PRIVATE).
add_library(glenoid_options INTERFACE)
target_compile_features(glenoid_options INTERFACE cxx_std_20)
# Contraction to fused multiply-add is off so that every compiler and processor computes the same bits.
target_compile_options(glenoid_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion
  $<$<COMPILE_LANGUAGE:CXX>:-Wnon-virtual-dtor -Wold-style-cast>
  -ffp-contract=off)
if(PROJECT_IS_TOP_LEVEL)
  target_compile_options(glenoid_options INTERFACE -Werror)
endif()
if(GLENOID_SANITIZE)
  target_compile_options(glenoid_options INTERFACE -fsanitize=${GLENOID_SANITIZE} -fno-omit-frame-pointer
                                                   -fno-sanitize-recover=all)
  target_link_options(glenoid_options INTERFACE -fsanitize=${GLENOID_SANITIZE})
  # Instrumented code defeats GCC's analysis (its manual says so): Eigen's alias check then reads "uninitialized" matrices.
  target_compile_options(glenoid_options INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
endif()
if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Build type" FORCE)
endif()
