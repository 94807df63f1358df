# What the checks of texts share: problem(<text>) prints a fault and counts it in `problems`; read_plain(<path> <out>) reads a file
# without what would make lists of its own.

set(problems 0)
function(problem text)
  math(EXPR count "${problems} + 1")
  set(problems ${count} PARENT_SCOPE)
  message(NOTICE "${text}")
endfunction()

# Square brackets and semicolons would make lists.
function(read_plain path out)
  file(READ "${path}" text)
  string(REPLACE ";" "," text "${text}")
  string(REPLACE "[" "(" text "${text}")
  string(REPLACE "]" ")" text "${text}")
  set(${out} "${text}" PARENT_SCOPE)
endfunction()
