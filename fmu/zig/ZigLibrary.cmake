# Cross-compiles core and FMU with the clang of the ziglang wheel: static C++ library, glibc 2.17 at the oldest, nothing
# else needed. Objects are cached in the build tree.

# glenoid_zig_library(PLATFORM RESULT): PLATFORM is an FMI 3.0 platform tuple; RESULT becomes the library's path.
function(glenoid_zig_library platform result)
  set(target_x86_64-linux x86_64-linux-gnu.2.17)
  set(target_aarch64-linux aarch64-linux-gnu.2.17)
  set(target_x86_64-windows x86_64-windows-gnu)
  set(target_x86_64-darwin x86_64-macos)
  set(target_aarch64-darwin aarch64-macos)
  if(NOT DEFINED target_${platform})
    message(FATAL_ERROR "GLENOID_FMU_PLATFORMS: ${platform} is not known")
  endif()
  set(flags -target ${target_${platform}} -std=c++20 -O3 -DNDEBUG -ffp-contract=off -fno-sanitize=all -fPIC
            -fvisibility=hidden -fvisibility-inlines-hidden -ffile-prefix-map=${CMAKE_SOURCE_DIR}=. -s -shared)
  set(suffix .so)
  set(sources ${core_sources} ${fmu_sources})
  if(platform MATCHES "x86_64")
    list(APPEND flags -mcpu=x86_64_v2)
  endif()
  if(platform MATCHES "linux")
    list(APPEND sources ${CMAKE_CURRENT_SOURCE_DIR}/zig/unload_elf.cpp)
    list(APPEND flags -include ${CMAKE_CURRENT_SOURCE_DIR}/zig/glibc_symbols.hpp -Wl,-z,defs -Wl,--version-script=${CMAKE_CURRENT_SOURCE_DIR}/exports.map)
  elseif(platform MATCHES "windows")
    set(suffix .dll)
  else()
    set(suffix .dylib)
  endif()
  set(library ${CMAKE_CURRENT_BINARY_DIR}/binaries/${platform}/Glenoid${suffix})
  file(MAKE_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}/binaries/${platform})
  add_custom_command(OUTPUT ${library}
    COMMAND ${CMAKE_COMMAND} -E env ZIG_GLOBAL_CACHE_DIR=${CMAKE_CURRENT_BINARY_DIR}/zig-cache
            ZIG_LOCAL_CACHE_DIR=${CMAKE_CURRENT_BINARY_DIR}/zig-cache
            ${GLENOID_ZIG_PYTHON} -m ziglang c++ ${flags} ${sources}
            -I ${generated} -I ${CMAKE_CURRENT_SOURCE_DIR}/src -I ${CMAKE_SOURCE_DIR}/core/include
            -isystem ${CMAKE_CURRENT_SOURCE_DIR}/headers -isystem ${eigen_include} -o ${library}
    DEPENDS ${sources} ${headers} ${table} ${CMAKE_CURRENT_SOURCE_DIR}/exports.map
            ${CMAKE_CURRENT_SOURCE_DIR}/zig/ZigLibrary.cmake ${CMAKE_CURRENT_SOURCE_DIR}/zig/glibc_symbols.hpp
    COMMENT "Glenoid${suffix} for ${platform} (zig; the first time it also compiles its C++ library)" VERBATIM)
  set(${result} ${library} PARENT_SCOPE)
endfunction()
