# Every third-party package, found once. The trainer-only build stops after the first group.
find_package(Threads REQUIRED)
find_package(glm REQUIRED)
find_package(fmt REQUIRED)
find_package(PNG REQUIRED)
find_package(ZLIB REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(CLI11 REQUIRED)
find_package(yaml-cpp REQUIRED)
if(NOT TARGET yaml-cpp::yaml-cpp)  # before 0.8
  add_library(yaml-cpp::yaml-cpp ALIAS yaml-cpp)
endif()
find_path(DEFLATE_INCLUDE_DIR libdeflate.h REQUIRED)  # inflates PNG
find_library(DEFLATE_LIBRARY deflate REQUIRED)
add_library(libdeflate::libdeflate UNKNOWN IMPORTED)
set_target_properties(libdeflate::libdeflate PROPERTIES
  IMPORTED_LOCATION ${DEFLATE_LIBRARY} INTERFACE_INCLUDE_DIRECTORIES ${DEFLATE_INCLUDE_DIR})
find_path(UTF8PROC_INCLUDE_DIR utf8proc.h REQUIRED)  # normal forms of names
find_library(UTF8PROC_LIBRARY utf8proc REQUIRED)
add_library(utf8proc::utf8proc UNKNOWN IMPORTED)
set_target_properties(utf8proc::utf8proc PROPERTIES
  IMPORTED_LOCATION ${UTF8PROC_LIBRARY} INTERFACE_INCLUDE_DIRECTORIES ${UTF8PROC_INCLUDE_DIR})
find_path(ZSTD_INCLUDE_DIR zstd.h)  # for .spz of version 4
find_library(ZSTD_LIBRARY zstd)
find_path(WEBP_INCLUDE_DIR webp/encode.h)  # for .sog
find_library(WEBP_LIBRARY webp)
find_package(TBB QUIET)  # oneTBB; std::thread is used where it is absent

if(NOT TESSERA_INGEST STREQUAL "OFF")
  find_package(PkgConfig QUIET)
  if(PkgConfig_FOUND)
    pkg_check_modules(LIBAV QUIET IMPORTED_TARGET libavformat libavcodec libavutil libswscale
                      libswresample)
    # not find_package: Debian's CMake files insist on programs of other packages
    pkg_check_modules(OIIO QUIET IMPORTED_TARGET OpenImageIO)
  endif()
  find_package(OpenCV QUIET COMPONENTS core imgproc video features2d
               OPTIONAL_COMPONENTS dnn)  # dnn: LPIPS
  if(LIBAV_FOUND AND OIIO_FOUND AND OpenCV_FOUND)
    set(TESSERA_HAS_INGEST TRUE)
  elseif(TESSERA_INGEST STREQUAL "ON")
    message(FATAL_ERROR "TESSERA_INGEST=ON needs FFmpeg (libav*), OpenImageIO and OpenCV; "
                        "run scripts/install_packages.sh or pass -DTESSERA_INGEST=OFF")
  endif()
endif()
if(NOT TESSERA_HAS_INGEST)
  set(TESSERA_HAS_INGEST FALSE)
  message(STATUS "Trainer-only build: prepared scenes and D-NeRF folders, no video or image ingest")
endif()

if(NOT TESSERA_CUDA STREQUAL "OFF")
  include(CheckLanguage)
  check_language(CUDA)
  if(CMAKE_CUDA_COMPILER)
    if(NOT DEFINED CMAKE_CUDA_ARCHITECTURES)
      include(cmake/cuda_architectures.cmake)
      tessera_cuda_architectures(CMAKE_CUDA_ARCHITECTURES)
    endif()
    enable_language(CUDA)
    message(STATUS "CUDA kernels for: ${CMAKE_CUDA_ARCHITECTURES}")
    # CMake 3.25 does not know this flag of nvcc 13
    set(CMAKE_CUDA20_STANDARD_COMPILE_OPTION "-std=c++20")
    set(TESSERA_HAS_CUDA TRUE)
  elseif(TESSERA_CUDA STREQUAL "ON")
    message(FATAL_ERROR "TESSERA_CUDA=ON needs nvcc (CUDA >= 12.4) in PATH or in CUDACXX")
  endif()
endif()

if(TESSERA_TESTS)
  find_package(GTest REQUIRED)
endif()
