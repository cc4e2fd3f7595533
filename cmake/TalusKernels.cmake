# How constitutive laws and physics are compiled, in the tree and outside of it.

# The instances of a kernel, kinematics:name:form. Here and nowhere else. The name is the number of derivative directions; few
# physics are compiled in the form SENSITIVITY. Numbers of the kinematics are those of MpmKinematics.
set(TALUS_INSTANCES
  2d:0:RESIDUAL 2d:1:DIRECTION 2d:4:TANGENT 2d:sensitivity:SENSITIVITY
  3d:0:RESIDUAL 3d:1:DIRECTION 3d:9:TANGENT 3d:sensitivity:SENSITIVITY
  axial:0:RESIDUAL axial:1:DIRECTION axial:5:TANGENT axial:sensitivity:SENSITIVITY)
set(TALUS_NUMBER_2d 2)
set(TALUS_NUMBER_3d 3)
set(TALUS_NUMBER_axial 4)

# The instances SENSITIVITY are compiled as C++ where there is a compiler for it: their numbers have derivatives in eight
# directions then, in one otherwise (talus/point/real.h).
include(CheckCSourceCompiles)
set(TALUS_PACK_OPTIONS -x c++ -std=gnu++17 -fno-exceptions -fno-rtti -Wno-missing-field-initializers)
function(talus_check_packs)
  unset(CMAKE_C_STANDARD)
  set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
  set(CMAKE_REQUIRED_FLAGS "-x c++ -std=gnu++17")
  check_c_source_compiles("#include <math.h>
template <typename Number> static Number Twice(Number a) { return a + a; }
int main(void) { return Twice(sqrt(0.)) > 1.; }" TALUS_HAS_PACKS)
endfunction()
talus_check_packs()

# Lets a target of kernels in the form SENSITIVITY have packs of directions.
function(talus_compile_in_packs target)
  if(TALUS_HAS_PACKS)
    set_property(TARGET ${target} PROPERTY C_STANDARD)
    target_compile_options(${target} PRIVATE ${TALUS_PACK_OPTIONS})
  endif()
endfunction()

# Takes an instance apart, with the definitions that it is compiled with.
function(talus_instance instance kind name form definitions)
  string(REPLACE ":" ";" parts ${instance})
  list(GET parts 0 the_kind)
  list(GET parts 1 the_name)
  list(GET parts 2 the_form)
  set(list MPM_DIM=2)
  if(the_kind STREQUAL 3d)
    set(list MPM_DIM=3)
  elseif(the_kind STREQUAL axial)
    list(APPEND list MPM_AXISYMMETRIC)
  endif()
  if(the_form STREQUAL SENSITIVITY)
    list(APPEND list MPM_DIRECTIONS=1 MPM_SENSITIVITY)
  else()
    list(APPEND list MPM_DIRECTIONS=${the_name})
  endif()
  set(${definitions} ${list} PARENT_SCOPE)
  set(${kind} ${the_kind} PARENT_SCOPE)
  set(${name} ${the_name} PARENT_SCOPE)
  set(${form} ${the_form} PARENT_SCOPE)
endfunction()

# talus_add_plugin(NAME [LAWS FILE...] [PHYSICS FILE... [DIRECTIONS N2 N3]] [TERMS FILE...]
#                  [CONTACT_BODIES FILE...] [SOURCES FILE...])
#
# A library NAME.so for -mpm_plugin.
#   LAWS        files NAME.c with MPM_LAW(NAME, ...), as in materials/: the law NAME
#   PHYSICS     files NAME.c with MPM_KERNEL(NAME, ...) or MPM_KERNEL_MEAN(NAME, ...), and MPM_PHYSICS(NAME, ...), as in
#               physics/: the physics NAME
#   DIRECTIONS  of the physics' kernel, as many as it has inputs, in plane strain and in 3D (with axial symmetry one more than
#               in plane strain); without it the components of dF
#   TERMS       files NAME.c with a const MpmTermType MpmTermType_NAME (talus/term.h): the type of term NAME
#   CONTACT_BODIES files NAME.c with a const MpmContactBodyType MpmContactBodyType_NAME (talus/contact.h): boundaries of type NAME
#   SOURCES     other files
function(talus_add_plugin name)
  cmake_parse_arguments(PARSE_ARGV 1 plugin "" "" "LAWS;PHYSICS;DIRECTIONS;TERMS;CONTACT_BODIES;SOURCES")
  set(physics_instances ${TALUS_INSTANCES})
  list(FILTER physics_instances EXCLUDE REGEX SENSITIVITY)
  if(plugin_DIRECTIONS)
    list(GET plugin_DIRECTIONS 0 in_2d)
    list(GET plugin_DIRECTIONS 1 in_3d)
    math(EXPR in_axial "${in_2d} + 1")
    set(physics_instances 2d:0:RESIDUAL 2d:1:DIRECTION 2d:${in_2d}:TANGENT 3d:0:RESIDUAL 3d:1:DIRECTION 3d:${in_3d}:TANGENT
      axial:0:RESIDUAL axial:1:DIRECTION axial:${in_axial}:TANGENT)
  endif()
  set(TALUS_DECLARATIONS "")
  set(TALUS_LAWS "")
  set(TALUS_PHYSICS "")
  set(TALUS_TERMS "")
  set(TALUS_CONTACT_BODIES "")
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
      talus_instance(${instance} kind count form definitions)
      set(suffix ${kernel}_${kind}_${count})
      if(file IN_LIST plugin_LAWS)
        string(APPEND TALUS_DECLARATIONS "void MpmMaterialCreate_${suffix}(MpmLawInfo *info);\n")
        string(APPEND TALUS_LAWS "    {\"${kernel}\", ${TALUS_NUMBER_${kind}}, MPM_FORM_${form}, MpmMaterialCreate_${suffix}},\n")
      else()
        string(APPEND TALUS_DECLARATIONS "void MpmKernelCreate_${suffix}(MpmKernelSet *set);\n")
        string(APPEND TALUS_PHYSICS "  MpmKernelCreate_${suffix}(&physics.kernels[${TALUS_NUMBER_${kind}}]);\n")
      endif()
      add_library(${name}_${suffix} OBJECT ${file})
      target_compile_definitions(${name}_${suffix} PRIVATE ${definitions})
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
  foreach(file ${plugin_TERMS})
    get_filename_component(term ${file} NAME_WE)
    string(APPEND TALUS_DECLARATIONS "extern const MpmTermType MpmTermType_${term};\n")
    string(APPEND TALUS_TERMS "  PetscCall(host->register_term(&MpmTermType_${term}));\n")
  endforeach()
  foreach(file ${plugin_CONTACT_BODIES})
    get_filename_component(body ${file} NAME_WE)
    string(APPEND TALUS_DECLARATIONS "extern const MpmContactBodyType MpmContactBodyType_${body};\n")
    string(APPEND TALUS_CONTACT_BODIES "  PetscCall(host->register_contact_body(&MpmContactBodyType_${body}));\n")
  endforeach()
  configure_file(${TALUS_KERNELS_DIR}/plugin.c.in ${CMAKE_CURRENT_BINARY_DIR}/${name}_plugin.c @ONLY)
  add_library(${name} MODULE ${CMAKE_CURRENT_BINARY_DIR}/${name}_plugin.c ${plugin_TERMS}
    ${plugin_CONTACT_BODIES} ${plugin_SOURCES} ${objects})
  target_link_libraries(${name} PRIVATE Talus::headers m)
  set_target_properties(${name} PROPERTIES PREFIX "" SUFFIX ".so" C_VISIBILITY_PRESET hidden C_STANDARD 11)
endfunction()
set(TALUS_KERNELS_DIR ${CMAKE_CURRENT_LIST_DIR})
