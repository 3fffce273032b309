# Buses and messages.
add_library(glenoid_wires_network STATIC wires_network.cpp)
target_include_directories(glenoid_wires_network PUBLIC ${CMAKE_CURRENT_SOURCE_DIR}/..)
target_link_libraries(glenoid_wires_network PUBLIC glenoid::can PRIVATE glenoid_options)

foreach(noun bus_load memory_bus error_frame datagram port)
  glenoid_add_test(wires_${noun}_test wires_${noun}_test.cpp)
  target_link_libraries(wires_${noun}_test PRIVATE glenoid_wires_network)
endforeach()
foreach(noun inbox lcm)
  glenoid_add_test(wires_${noun}_test wires_${noun}_test.cpp)
  target_link_libraries(wires_${noun}_test PRIVATE glenoid_wires_network glenoid::lcm_port)
endforeach()

add_executable(wires_probe wires_probe.cpp)
target_link_libraries(wires_probe PRIVATE glenoid::can glenoid::bridge_core glenoid_options)
