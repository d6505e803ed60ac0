# Debian packages: `cmake --workflow --preset package` writes build/package/tessera_VERSION_ARCH.deb.
# TESSERA_PACKAGE builds for any CPU of the architecture. The kernels are a shared library there, of
# which a second copy uses AVX2 and FMA (x86-64-v3); the dynamic loader takes the best one that the
# CPU can execute (ld.so(8), glibc-hwcaps).
option(TESSERA_PACKAGE "Build what a Debian package holds" OFF)
if(TESSERA_PACKAGE)
  set(TESSERA_NATIVE OFF)  # whatever was asked for
endif()
set(TESSERA_MAINTAINER "Tessera maintainers <tessera@example.org>" CACHE STRING
    "Who a package names as its maintainer")
include(GNUInstallDirs)
# in the architecture's folder: below lib itself CPack takes it for a library of the system's
set(TESSERA_PRIVATE_LIBRARIES ${CMAKE_INSTALL_LIBDIR}/${CMAKE_LIBRARY_ARCHITECTURE}/tessera)

# Makes `target`, a library of the layer's sources, shared, with a copy for newer CPUs.
function(tessera_package_library target)
  set(folder ${PROJECT_BINARY_DIR}/lib)
  get_target_property(sources ${target} SOURCES)
  get_target_property(links ${target} LINK_LIBRARIES)
  set(copies ${target})
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64|amd64)$" AND NOT TESSERA_HAS_CUDA)
    add_library(${target}_v3 SHARED ${sources})
    target_link_libraries(${target}_v3 PUBLIC ${links})
    tessera_configure(${target}_v3)
    target_compile_options(${target}_v3 PRIVATE -march=x86-64-v3)
    set_target_properties(${target}_v3 PROPERTIES
      OUTPUT_NAME ${target}
      LIBRARY_OUTPUT_DIRECTORY ${folder}/glibc-hwcaps/x86-64-v3)
    install(TARGETS ${target}_v3
            LIBRARY DESTINATION ${TESSERA_PRIVATE_LIBRARIES}/glibc-hwcaps/x86-64-v3)
    list(APPEND copies ${target}_v3)
  endif()
  set_target_properties(${target} PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${folder})
  set_target_properties(${copies} PROPERTIES UNITY_BUILD OFF)
  # a copy calls its own functions, not those that the program has of the same headers; data stay one
  foreach(copy ${copies})
    target_link_options(${copy} PRIVATE -Wl,-Bsymbolic-functions)
  endforeach()
  install(TARGETS ${target} LIBRARY DESTINATION ${TESSERA_PRIVATE_LIBRARIES})
endfunction()

# The revision of the package, which tells the releases of distributions apart: 1~debian12.
function(tessera_package_revision result)
  cmake_host_system_information(RESULT system QUERY DISTRIB_INFO)
  string(TOLOWER "1~${system_ID}${system_VERSION_ID}" revision)
  set(${result} ${revision} PARENT_SCOPE)
endfunction()

# Files that Debian's policy asks for: changelogs and copyright, manual pages compressed.
function(tessera_package_documents name revision)
  set(documents ${CMAKE_INSTALL_DATAROOTDIR}/doc/${name})
  string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
  set(debian ${PROJECT_BINARY_DIR}/changelog.Debian)
  file(WRITE ${debian}
    "${name} (${PROJECT_VERSION}-${revision}) unstable; urgency=medium\n\n"
    "  * Package of this release; changelog.gz has its changes.\n\n"
    " -- ${TESSERA_MAINTAINER}  ${date}\n")
  install(FILES ${PROJECT_SOURCE_DIR}/cmake/copyright ${PROJECT_SOURCE_DIR}/README.md
          DESTINATION ${documents})
  install(CODE "
    set(root \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}\")
    file(COPY \"${PROJECT_SOURCE_DIR}/CHANGELOG.md\" DESTINATION \"\${root}/${documents}\")
    file(RENAME \"\${root}/${documents}/CHANGELOG.md\" \"\${root}/${documents}/changelog\")
    file(COPY \"${debian}\" DESTINATION \"\${root}/${documents}\")
    file(GLOB pages \"\${root}/share/man/man1/tessera*.1\")
    execute_process(COMMAND gzip -9nf \"\${root}/${documents}/changelog\"
                            \"\${root}/${documents}/changelog.Debian\" \${pages}
                    COMMAND_ERROR_IS_FATAL ANY)")
endfunction()

# To be called after all install rules.
function(tessera_package)
  tessera_package_revision(revision)
  if(TESSERA_HAS_CUDA)
    set(name tessera-cuda)
    set(CPACK_DEBIAN_PACKAGE_PROVIDES tessera)
    set(CPACK_DEBIAN_PACKAGE_CONFLICTS tessera)
  else()
    set(name tessera)
  endif()
  tessera_package_documents(${name} ${revision})
  set(CPACK_GENERATOR DEB)
  set(CPACK_PACKAGE_NAME ${name})
  set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
  set(CPACK_DEBIAN_PACKAGE_RELEASE ${revision})
  set(CPACK_PACKAGE_CONTACT "${TESSERA_MAINTAINER}")
  set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR})
  set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
  set(CPACK_STRIP_FILES ON)
  set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
  set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
  string(JOIN "\n" CPACK_DEBIAN_PACKAGE_DESCRIPTION
    "multi-view video to 4D Gaussians and to splat sequences that play"
    "Tessera takes videos or photos of several cameras, estimates what is not"
    "known of the cameras, trains static and dynamic Gaussians, scores them on"
    "held-out views, and writes a web page that plays the scene from any view."
    "It also exports splat files for other programs.")
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/lib)
  set(CPACK_DEBIAN_PACKAGE_RECOMMENDS colmap)  # for captures without poses
  set(CPACK_DEBIAN_PACKAGE_SUGGESTS "ffmpeg, snakemake")
  include(CPack)
endfunction()
