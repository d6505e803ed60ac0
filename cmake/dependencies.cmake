# Every third-party package, found once. The trainer-only build stops after the first group.
find_package(Threads REQUIRED)
find_package(glm REQUIRED)
find_package(fmt REQUIRED)
find_package(PNG REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(CLI11 REQUIRED)
find_package(TBB QUIET)  # oneTBB; std::thread is used where it is absent

if(NOT TESSERA_INGEST STREQUAL "OFF")
  find_package(PkgConfig QUIET)
  if(PkgConfig_FOUND)
    pkg_check_modules(LIBAV QUIET IMPORTED_TARGET libavformat libavcodec libavutil libswscale)
    # not find_package: Debian's CMake files insist on programs of other packages
    pkg_check_modules(OIIO QUIET IMPORTED_TARGET OpenImageIO)
  endif()
  find_package(OpenCV QUIET COMPONENTS core imgproc)
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

if(TESSERA_TESTS)
  find_package(GTest REQUIRED)
  include(GoogleTest)
endif()
