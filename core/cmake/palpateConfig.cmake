# The installed core for libraries that add to it (docs/extending.md): find_package(palpate CONFIG) with palpate_DIR, which
# `python -c "import palpate; print(palpate.cmake_dir())"` prints.
#   palpate::core      contact methods, surfaces, all stages
#   palpate::guidance  geometries of virtual fixtures
get_filename_component(PALPATE_PACKAGE "${CMAKE_CURRENT_LIST_DIR}" DIRECTORY)
find_path(PALPATE_EIGEN Eigen/Core HINTS "${PALPATE_PACKAGE}/../cmeel.prefix/include/eigen3" PATH_SUFFIXES eigen3 REQUIRED)
foreach(part core guidance)
  string(REPLACE "palpate_core" "palpate" library "palpate_${part}")
  if(EXISTS "${PALPATE_PACKAGE}/lib${library}.so" AND NOT TARGET palpate::${part})
    add_library(palpate::${part} SHARED IMPORTED)
    set_target_properties(palpate::${part} PROPERTIES IMPORTED_LOCATION "${PALPATE_PACKAGE}/lib${library}.so")
    target_include_directories(palpate::${part} SYSTEM INTERFACE "${PALPATE_PACKAGE}/include" "${PALPATE_EIGEN}")
    target_compile_features(palpate::${part} INTERFACE cxx_std_20)
    # Pinocchio and its libraries, which no added part needs, are found when the core is loaded.
    target_link_options(palpate::${part} INTERFACE -Wl,--allow-shlib-undefined)
  endif()
endforeach()
if(TARGET palpate::guidance)
  target_link_libraries(palpate::guidance INTERFACE palpate::core)
endif()
