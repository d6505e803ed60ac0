# One way to make a layer's library: sources are listed, links are explicit, flags are the same.
function(tessera_configure target)
  target_include_directories(${target} PUBLIC ${PROJECT_SOURCE_DIR})
  set(cxx_flags -Wall -Wextra -Wshadow -Wnon-virtual-dtor
    # Neither flag changes a value; both let the compiler vectorise comparisons and square roots.
    -fno-math-errno -fno-trapping-math)
  # 20012: GLM's defaulted members carry an annotation that nvcc ignores
  set(cuda_flags --expt-relaxed-constexpr --extended-lambda -diag-suppress 20012)
  if(TESSERA_NATIVE)
    list(APPEND cxx_flags -march=native)
  endif()
  list(LENGTH CMAKE_CUDA_ARCHITECTURES cards)
  if(cards GREATER 1)
    list(APPEND cuda_flags --threads=4)  # one file for several cards at once
  endif()
  if(TESSERA_WERROR)
    list(APPEND cxx_flags -Werror)
    list(APPEND cuda_flags -Werror all-warnings)
  endif()
  target_compile_options(${target} PRIVATE "$<$<COMPILE_LANGUAGE:CXX>:${cxx_flags}>"
                                           "$<$<COMPILE_LANGUAGE:CUDA>:${cuda_flags}>")
  if(TESSERA_SANITIZE)
    target_compile_options(${target} PUBLIC -fsanitize=address,undefined -fno-omit-frame-pointer
                                            -fno-sanitize-recover=undefined)
    target_link_options(${target} PUBLIC -fsanitize=address,undefined)
  endif()
endfunction()

# Sources of this folder that run before it is known what the CPU can execute.
function(tessera_for_any_cpu)
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64|amd64)$")
    set_source_files_properties(${ARGN} PROPERTIES COMPILE_OPTIONS -march=x86-64)
  endif()
endfunction()

# tessera_library(NAME kernels [TYPE SHARED] [ALL_LOOPS] SOURCES a.cpp … [LOOPS b.cpp …] PUBLIC targets…
# PRIVATE targets…): SOURCES are files, words and decisions, for which -O1 does; -O3 would take half as
# long again to compile them. LOOPS are those over pixels, points and Gaussians, and optimised in full;
# ALL_LOOPS: all sources are.
function(tessera_library)
  cmake_parse_arguments(LIB "ALL_LOOPS" "NAME;TYPE" "SOURCES;LOOPS;PUBLIC;PRIVATE" ${ARGN})
  if(NOT LIB_TYPE)
    set(LIB_TYPE STATIC)
  endif()
  set(target tessera_${LIB_NAME})
  add_library(${target} ${LIB_TYPE} ${LIB_SOURCES})
  target_link_libraries(${target} PUBLIC ${LIB_PUBLIC} PRIVATE ${LIB_PRIVATE})
  tessera_configure(${target})
  if(NOT LIB_ALL_LOOPS)
    tessera_light(${target})
  endif()
  if(LIB_LOOPS)
    add_library(${target}_loops OBJECT ${LIB_LOOPS})
    target_link_libraries(${target}_loops PRIVATE ${LIB_PUBLIC} ${LIB_PRIVATE})
    tessera_configure(${target}_loops)
    target_sources(${target} PRIVATE $<TARGET_OBJECTS:${target}_loops>)
  endif()
endfunction()

# Less optimisation for the C++ of a target than a release build has by itself.
function(tessera_light target)
  target_compile_options(${target} PRIVATE
    $<$<AND:$<COMPILE_LANGUAGE:CXX>,$<CONFIG:Release,RelWithDebInfo>>:-O1>)
endfunction()

# tessera_test(NAME kernels SOURCES a_test.cpp … LINKS targets… [LABELS nightly] [SHARDS 4] [EXACT]): one
# program, run in as many parts, each of every SHARDS-th case: starting a process for each case costs
# more than most cases. EXACT: compiled as the product is and file by file, for comparisons to the bit.
function(tessera_test)
  cmake_parse_arguments(TEST "EXACT" "NAME;SHARDS" "SOURCES;LINKS;LABELS" ${ARGN})
  add_executable(${TEST_NAME}_test ${TEST_SOURCES})
  target_link_libraries(${TEST_NAME}_test PRIVATE ${TEST_LINKS} GTest::gtest_main)
  tessera_configure(${TEST_NAME}_test)
  if(TEST_EXACT)
    set_target_properties(${TEST_NAME}_test PROPERTIES UNITY_BUILD OFF)
  else()
    # What a test checks is optimised as in the product; the test itself need not be. Beside each
    # other in a unity build, tests shadow each other's names.
    tessera_light(${TEST_NAME}_test)
    target_compile_options(${TEST_NAME}_test PRIVATE -Wno-shadow)
  endif()
  if(TESSERA_SANITIZE)
    target_compile_options(${TEST_NAME}_test PRIVATE -O0)
    target_sources(${TEST_NAME}_test PRIVATE ${PROJECT_SOURCE_DIR}/tests/support/leaks_not_ours.cpp)
  endif()
  if(NOT TEST_LABELS)
    set(TEST_LABELS cpu)
  endif()
  if(NOT TEST_SHARDS)
    set(TEST_SHARDS 1)
  endif()
  math(EXPR last_shard "${TEST_SHARDS} - 1")
  foreach(shard RANGE ${last_shard})
    add_test(NAME ${TEST_NAME}/${shard} COMMAND ${TEST_NAME}_test)
    set_tests_properties(${TEST_NAME}/${shard} PROPERTIES
      LABELS "${TEST_LABELS}" TIMEOUT 1800
      ENVIRONMENT "GTEST_TOTAL_SHARDS=${TEST_SHARDS};GTEST_SHARD_INDEX=${shard};GTEST_BRIEF=1")
  endforeach()
endfunction()
