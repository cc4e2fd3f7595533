# How constitutive laws and physics are compiled, in the tree and outside of it.

# The instances of a kernel, dimension:name:form. Here and nowhere else. The name is the number of derivative directions; physics are
# not compiled in the form SENSITIVITY.
set(TALUS_INSTANCES
  2:0:RESIDUAL 2:1:DIRECTION 2:4:TANGENT 2:sensitivity:SENSITIVITY
  3:0:RESIDUAL 3:1:DIRECTION 3:9:TANGENT 3:sensitivity:SENSITIVITY)

# Takes an instance apart, with the definitions that it is compiled with.
function(talus_instance instance dim name form definitions)
  string(REPLACE ":" ";" parts ${instance})
  list(GET parts 0 the_dim)
  list(GET parts 1 the_name)
  list(GET parts 2 the_form)
  if(the_form STREQUAL SENSITIVITY)
    set(${definitions} MPM_DIRECTIONS=1 MPM_SENSITIVITY PARENT_SCOPE)
  else()
    set(${definitions} MPM_DIRECTIONS=${the_name} PARENT_SCOPE)
  endif()
  set(${dim} ${the_dim} PARENT_SCOPE)
  set(${name} ${the_name} PARENT_SCOPE)
  set(${form} ${the_form} PARENT_SCOPE)
endfunction()

# talus_add_plugin(NAME [LAWS FILE...] [PHYSICS FILE... [DIRECTIONS N2 N3]] [SOURCES FILE...])
#
# A library NAME.so for -mpm_plugin.
#   LAWS        files NAME.c with MPM_LAW(NAME, ...), as in materials/: the law NAME
#   PHYSICS     files NAME.c with MPM_KERNEL(NAME, ...) or MPM_KERNEL_MEAN(NAME, ...), and MPM_PHYSICS(NAME, ...), as in
#               physics/: the physics NAME
#   DIRECTIONS  of the physics' kernel, as many as it has inputs, in 2D and in 3D; without it dim^2, those of dF
#   SOURCES     other files
function(talus_add_plugin name)
  cmake_parse_arguments(PARSE_ARGV 1 plugin "" "" "LAWS;PHYSICS;DIRECTIONS;SOURCES")
  set(physics_instances ${TALUS_INSTANCES})
  list(FILTER physics_instances EXCLUDE REGEX SENSITIVITY)
  if(plugin_DIRECTIONS)
    list(GET plugin_DIRECTIONS 0 in_2d)
    list(GET plugin_DIRECTIONS 1 in_3d)
    set(physics_instances 2:0:RESIDUAL 2:1:DIRECTION 2:${in_2d}:TANGENT 3:0:RESIDUAL 3:1:DIRECTION 3:${in_3d}:TANGENT)
  endif()
  set(TALUS_DECLARATIONS "")
  set(TALUS_LAWS "")
  set(TALUS_PHYSICS "")
  set(objects "")
  foreach(file ${plugin_LAWS} ${plugin_PHYSICS})
    get_filename_component(kernel ${file} NAME_WE)
    if(file IN_LIST plugin_LAWS)
      set(instances ${TALUS_INSTANCES})
    else()
      set(instances ${physics_instances})
      string(APPEND TALUS_DECLARATIONS "void MpmPhysicsDescribe_${kernel}(MpmPhysics *physics);\n")
      string(APPEND TALUS_PHYSICS "  memset(&physics, 0, sizeof(physics));\n  MpmPhysicsDescribe_${kernel}(&physics);\n")
    endif()
    foreach(instance ${instances})
      talus_instance(${instance} dim count form definitions)
      set(suffix ${kernel}_${dim}d_${count})
      if(file IN_LIST plugin_LAWS)
        string(APPEND TALUS_DECLARATIONS "void MpmMaterialCreate_${suffix}(MpmLawInfo *info);\n")
        string(APPEND TALUS_LAWS "    {\"${kernel}\", ${dim}, MPM_FORM_${form}, MpmMaterialCreate_${suffix}},\n")
      else()
        string(APPEND TALUS_DECLARATIONS "void MpmKernelCreate_${suffix}(MpmKernelSet *set);\n")
        string(APPEND TALUS_PHYSICS "  MpmKernelCreate_${suffix}(&physics.kernels[${dim}]);\n")
      endif()
      add_library(${name}_${suffix} OBJECT ${file})
      target_compile_definitions(${name}_${suffix} PRIVATE MPM_DIM=${dim} ${definitions})
      target_compile_options(${name}_${suffix} PRIVATE ${TALUS_KERNEL_OPTIONS})
      target_link_libraries(${name}_${suffix} PRIVATE Talus::headers)
      set_target_properties(${name}_${suffix} PROPERTIES POSITION_INDEPENDENT_CODE ON C_VISIBILITY_PRESET hidden
        C_STANDARD 11 C_STANDARD_REQUIRED ON)
      list(APPEND objects $<TARGET_OBJECTS:${name}_${suffix}>)
    endforeach()
    if(file IN_LIST plugin_PHYSICS)
      string(APPEND TALUS_PHYSICS "  PetscCall(host->register_physics(&physics));\n")
    endif()
  endforeach()
  configure_file(${TALUS_KERNELS_DIR}/plugin.c.in ${CMAKE_CURRENT_BINARY_DIR}/${name}_plugin.c @ONLY)
  add_library(${name} MODULE ${CMAKE_CURRENT_BINARY_DIR}/${name}_plugin.c ${plugin_SOURCES} ${objects})
  target_link_libraries(${name} PRIVATE Talus::headers m)
  set_target_properties(${name} PROPERTIES PREFIX "" SUFFIX ".so" C_VISIBILITY_PRESET hidden C_STANDARD 11)
endfunction()
set(TALUS_KERNELS_DIR ${CMAKE_CURRENT_LIST_DIR})
