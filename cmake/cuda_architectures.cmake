# Which cards CUDA code is compiled for, where CMAKE_CUDA_ARCHITECTURES does not say.

# Every card of compute capability 7.5 and more: machine code for those there are, PTX of the last
# for newer ones. Of these as many as this nvcc knows.
function(tessera_every_card result)
  execute_process(COMMAND ${CMAKE_CUDA_COMPILER} --list-gpu-arch OUTPUT_VARIABLE known)
  set(cards)
  foreach(card 75 80 86 89 90 100 120)
    if(known MATCHES "compute_${card}[^0-9]")
      list(APPEND cards ${card})
    endif()
  endforeach()
  if(NOT cards)
    message(FATAL_ERROR "${CMAKE_CUDA_COMPILER} --list-gpu-arch names no card of compute "
                        "capability 7.5 to 12.0; pass -DCMAKE_CUDA_ARCHITECTURES=...")
  endif()
  list(POP_BACK cards newest)
  list(TRANSFORM cards APPEND -real)
  set(${result} ${cards} ${newest} PARENT_SCOPE)
endfunction()

function(tessera_cuda_architectures result)
  if(TESSERA_CUDA_CARDS STREQUAL "AUTO" AND (EXISTS /dev/nvidia0 OR EXISTS /dev/dxg))
    set(${result} native PARENT_SCOPE)
  else()
    tessera_every_card(cards)
    set(${result} ${cards} PARENT_SCOPE)
  endif()
endfunction()
