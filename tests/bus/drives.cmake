# Simulated drives.
glenoid_add_test(drives_test drives_arm_dynamics_test.cpp drives_bench.cpp drives_brake_test.cpp drives_canopen_test.cpp drives_faults_test.cpp
                 drives_group_test.cpp drives_load_test.cpp drives_motion_test.cpp drives_objects_test.cpp)
target_link_libraries(drives_test PRIVATE glenoid::drives_io glenoid::load)
target_compile_definitions(drives_test PRIVATE GLENOID_DRIVE_PROFILES="${PROJECT_SOURCE_DIR}/host/drives/profiles")

glenoid_add_test(drives_rig_test drives_rig_test.cpp)
target_link_libraries(drives_rig_test PRIVATE glenoid::rig)
target_compile_definitions(drives_rig_test PRIVATE GLENOID_RIG_CONFIG="${PROJECT_SOURCE_DIR}/host/rehearsals/bridge/six_drives.yaml")
