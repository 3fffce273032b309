# Everything that reads bytes from outside. With any compiler the targets run their corpus, whole, cut and damaged, as tests.
# With clang they are libFuzzer's:
#
#     cmake --workflow --preset fuzz              build them with sanitizers and run the corpus
#     cmake --build build/fuzz --target fuzz      run each for GLENOID_FUZZ_SECONDS from its corpus; finds stay in build/fuzz/found
option(GLENOID_FUZZ "Build the fuzz targets with libFuzzer (clang)" OFF)
set(GLENOID_FUZZ_SECONDS 180 CACHE STRING "How long the target fuzz runs each of them")
add_custom_target(fuzz_targets)
set(glenoid_fuzz_runs)

function(glenoid_add_fuzz name source)
  set(program fuzz_${name})
  set(corpus ${CMAKE_CURRENT_SOURCE_DIR}/corpus/${name})
  add_executable(${program} ${source} $<$<NOT:$<BOOL:${GLENOID_FUZZ}>>:${CMAKE_CURRENT_SOURCE_DIR}/fuzz_replay.cpp>)
  target_link_libraries(${program} PRIVATE ${ARGN} glenoid_options)
  add_dependencies(fuzz_targets ${program})
  add_test(NAME Fuzz.${name} COMMAND ${program} -runs=0 ${corpus})
  if(GLENOID_FUZZ)
    target_compile_options(${program} PRIVATE -fsanitize=fuzzer)
    target_link_options(${program} PRIVATE -fsanitize=fuzzer)
    set(found ${PROJECT_BINARY_DIR}/found/${name})
    list(APPEND glenoid_fuzz_runs COMMAND ${CMAKE_COMMAND} -E make_directory ${found}
      COMMAND ${program} -max_total_time=${GLENOID_FUZZ_SECONDS} -timeout=10 -rss_limit_mb=2048 -print_final_stats=1
              -artifact_prefix=${found}/ ${found} ${corpus})
    set(glenoid_fuzz_runs ${glenoid_fuzz_runs} PARENT_SCOPE)
  endif()
endfunction()

glenoid_add_fuzz(config fuzz_config.cpp glenoid::bridge_config)
glenoid_add_fuzz(datagram fuzz_datagram.cpp glenoid::can)
glenoid_add_fuzz(frames fuzz_frames.cpp glenoid::bridge_core)
# The rig without the rest of the test support, which would have the whole of core/ built again.
target_sources(fuzz_frames PRIVATE bridge_fake_drive.cpp bridge_rig.cpp ../support/allocation_guard.cpp)
target_include_directories(fuzz_frames PRIVATE ${CMAKE_CURRENT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR}/..)
glenoid_add_fuzz(message fuzz_message.cpp glenoid::lcm_port)

if(GLENOID_FUZZ)
  target_compile_definitions(fuzz_frames PRIVATE __SANITIZE_ADDRESS__)  # what GCC tells the allocation guard
  foreach(room glenoid_can glenoid_lcm_port glenoid_bridge_core glenoid_bridge_config)
    target_compile_options(${room} PRIVATE -fsanitize=fuzzer-no-link)
  endforeach()
  add_custom_target(fuzz ${glenoid_fuzz_runs} DEPENDS fuzz_targets USES_TERMINAL VERBATIM)
endif()
