# Read only when pip builds this package against ROS from Python wheels (see pyproject.toml);
# a ROS 2 installation does not use it. It does two things that the wheels leave undone.

# 1. AMENT_PREFIX_PATH names the prefix of the wheels, which is where ament_cmake_core is found.
if(NOT DEFINED ENV{AMENT_PREFIX_PATH})
  find_package(ament_cmake_core REQUIRED)
  get_filename_component(_prefix "${ament_cmake_core_DIR}/../../.." ABSOLUTE)
  set(ENV{AMENT_PREFIX_PATH} "${_prefix}")
endif()

# 2. Imported targets name include folders of the machine that built the wheels: drop those
#    that do not exist here, which CMake would refuse.
function(_drop_missing_include_folders)
  get_property(_targets DIRECTORY PROPERTY IMPORTED_TARGETS)
  foreach(_target IN LISTS _targets)
    get_target_property(_folders ${_target} INTERFACE_INCLUDE_DIRECTORIES)
    if(NOT _folders)
      continue()
    endif()
    set(_kept)
    foreach(_folder IN LISTS _folders)
      if(_folder MATCHES "^\\$<" OR EXISTS "${_folder}")
        list(APPEND _kept "${_folder}")
      endif()
    endforeach()
    set_property(TARGET ${_target} PROPERTY INTERFACE_INCLUDE_DIRECTORIES "${_kept}")
  endforeach()
endfunction()
cmake_language(DEFER CALL _drop_missing_include_folders)
