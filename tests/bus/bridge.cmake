# The pure core with scripted drives, in virtual time.
add_library(glenoid_bridge_rig STATIC bridge_fake_drive.cpp bridge_rig.cpp)
target_include_directories(glenoid_bridge_rig PUBLIC ${CMAKE_CURRENT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR}/..)
target_link_libraries(glenoid_bridge_rig PUBLIC glenoid::bridge_core glenoid_test_support PRIVATE glenoid_options)

foreach(name codec fault motion run safety startup)
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
