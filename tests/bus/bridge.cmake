# The pure core with scripted drives, in virtual time.
add_library(glenoid_bridge_rig STATIC bridge_fake_drive.cpp bridge_rig.cpp)
target_include_directories(glenoid_bridge_rig PUBLIC ${CMAKE_CURRENT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR}/..)
target_link_libraries(glenoid_bridge_rig PUBLIC glenoid::bridge_core glenoid_test_support PRIVATE glenoid_options)

foreach(name codec fault motion run startup)
  glenoid_add_test(bridge_${name}_test bridge_${name}_test.cpp)
  target_link_libraries(bridge_${name}_test PRIVATE glenoid_bridge_rig)
endforeach()

glenoid_add_test(bridge_config_test bridge_config_test.cpp)
target_compile_definitions(bridge_config_test PRIVATE GLENOID_BRIDGE_EXAMPLES="${PROJECT_SOURCE_DIR}/host/bridge/examples")
target_link_libraries(bridge_config_test PRIVATE glenoid::bridge_config)
glenoid_add_test(bridge_loop_test bridge_loop_test.cpp)
target_link_libraries(bridge_loop_test PRIVATE glenoid::bridge_loop)

glenoid_add_test(bridge_rehearsal_test bridge_rehearsal_test.cpp ${PROJECT_SOURCE_DIR}/host/bridge/report.cpp)
target_link_libraries(bridge_rehearsal_test PRIVATE glenoid::bridge_loop glenoid::bridge_config)

# What reads bytes from outside, as in wires.cmake: libFuzzer with GLENOID_FUZZ, otherwise the corpus cut and damaged.
foreach(target config frames)
  add_executable(bridge_fuzz_${target} bridge_fuzz_${target}.cpp
                 $<$<NOT:$<BOOL:${GLENOID_FUZZ}>>:${CMAKE_CURRENT_SOURCE_DIR}/wires_fuzz_replay.cpp>)
  target_link_libraries(bridge_fuzz_${target} PRIVATE glenoid::bridge_config glenoid_bridge_rig glenoid_options)
  if(GLENOID_FUZZ)
    target_compile_options(bridge_fuzz_${target} PRIVATE -fsanitize=fuzzer)
    target_link_options(bridge_fuzz_${target} PRIVATE -fsanitize=fuzzer)
  endif()
  add_test(NAME Fuzz.${target} COMMAND bridge_fuzz_${target} -runs=0 ${CMAKE_CURRENT_SOURCE_DIR}/corpus/${target})
endforeach()
if(GLENOID_FUZZ)
  target_compile_options(glenoid_bridge_core PRIVATE -fsanitize=fuzzer-no-link)
  target_compile_options(glenoid_bridge_config PRIVATE -fsanitize=fuzzer-no-link)
endif()
