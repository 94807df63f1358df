# figures(row...): prints rows "claim | quantity | measured | limit | verdict" and adds them to the file that PHISTEP_FIGURES
# names, as support/figures.hpp does for programs.
function(figures)
  list(JOIN ARGN "" rows)
  message("${rows}")
  if(DEFINED ENV{PHISTEP_FIGURES})
    set(file "$ENV{PHISTEP_FIGURES}")
    cmake_path(GET file PARENT_PATH folder)
    file(MAKE_DIRECTORY "${folder}")
    file(APPEND "${file}" "${rows}")
  endif()
endfunction()
