# Buses and messages.
add_library(glenoid_wires_network STATIC wires_network.cpp)
target_include_directories(glenoid_wires_network PUBLIC ${CMAKE_CURRENT_SOURCE_DIR}/..)
target_link_libraries(glenoid_wires_network PUBLIC glenoid::can PRIVATE glenoid_options)

foreach(noun bus_load memory_bus error_frame datagram port)
  glenoid_add_test(wires_${noun}_test wires_${noun}_test.cpp)
  target_link_libraries(wires_${noun}_test PRIVATE glenoid_wires_network)
endforeach()
foreach(noun convert inbox lcm)
  glenoid_add_test(wires_${noun}_test wires_${noun}_test.cpp)
  target_link_libraries(wires_${noun}_test PRIVATE glenoid_wires_network glenoid::lcm_port)
endforeach()

add_executable(wires_probe wires_probe.cpp)
target_link_libraries(wires_probe PRIVATE glenoid::can glenoid::bridge_core glenoid_options)

# Debian's LCM, older than the wheel's, with types of its own generator: must understand each other.
find_program(GLENOID_SYSTEM_LCM_GEN lcm-gen PATHS /usr/bin NO_DEFAULT_PATH)
find_library(GLENOID_SYSTEM_LCM lcm)
find_path(GLENOID_SYSTEM_LCM_INCLUDE lcm/lcm-cpp.hpp PATHS /usr/include NO_DEFAULT_PATH)
if(GLENOID_SYSTEM_LCM_GEN AND GLENOID_SYSTEM_LCM AND GLENOID_SYSTEM_LCM_INCLUDE)
  set(peer_types ${CMAKE_CURRENT_BINARY_DIR}/lcm_peer)
  file(GLOB type_files CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/lcm_types/glenoid/*.lcm)
  add_custom_command(OUTPUT ${peer_types}/glenoid/status_v1_t.hpp DEPENDS ${type_files}
    COMMAND ${GLENOID_SYSTEM_LCM_GEN} -x --cpp-hpath ${peer_types} ${type_files} VERBATIM)
  add_executable(wires_lcm_peer wires_lcm_peer.cpp ${peer_types}/glenoid/status_v1_t.hpp)
  target_include_directories(wires_lcm_peer SYSTEM PRIVATE ${peer_types} ${GLENOID_SYSTEM_LCM_INCLUDE})
  target_link_libraries(wires_lcm_peer PRIVATE ${GLENOID_SYSTEM_LCM} glenoid_options)
endif()
