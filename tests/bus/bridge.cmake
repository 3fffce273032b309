# The pure core with scripted drives, in virtual time.
add_library(glenoid_bridge_rig STATIC bridge_fake_drive.cpp bridge_rig.cpp)
target_include_directories(glenoid_bridge_rig PUBLIC ${CMAKE_CURRENT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR}/..)
target_link_libraries(glenoid_bridge_rig PUBLIC glenoid::bridge_core glenoid_test_support PRIVATE glenoid_options)

foreach(name codec fault motion run startup)
  glenoid_add_test(bridge_${name}_test bridge_${name}_test.cpp)
  target_link_libraries(bridge_${name}_test PRIVATE glenoid_bridge_rig)
endforeach()
