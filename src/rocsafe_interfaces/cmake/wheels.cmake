# What a package of interfaces needs where ROS comes from wheels; on a distribution install it
# changes nothing. Included after all find_package calls.

# ROS packages installed from wheels record Python include directories of the machine that built
# them, and CMake refuses imported targets whose include directories do not exist. Drop those.
# Nothing is missing, so nothing is dropped, on a distribution install.
get_property(imported_targets DIRECTORY PROPERTY IMPORTED_TARGETS)
foreach(target IN LISTS imported_targets)
  get_target_property(include_dirs ${target} INTERFACE_INCLUDE_DIRECTORIES)
  if(include_dirs)
    set(kept_dirs)
    foreach(dir IN LISTS include_dirs)
      if(dir MATCHES "\\$<" OR EXISTS "${dir}")
        list(APPEND kept_dirs "${dir}")
      endif()
    endforeach()
    set_target_properties(${target} PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${kept_dirs}")
  endif()
endforeach()

# The wheels bring rclpy with rmw_fastrtps_cpp, and no rclcpp. What only C++ nodes load would
# lengthen this build, so it is left out where rclcpp is missing. The introspection of C stays:
# rmw_fastrtps_cpp describes each type by it.
find_package(rclcpp QUIET)
if(NOT rclcpp_FOUND)
  list(FILTER AMENT_EXTENSIONS_rosidl_generate_idl_interfaces EXCLUDE REGEX
    "^(rosidl_generator_cpp|rosidl_typesupport_(introspection_cpp|fastrtps_cpp|cpp)):")
endif()
