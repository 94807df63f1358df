// The macros of windows.h whose names a library might use.
#ifndef NOMINMAX
#define min(a, b) (((a) < (b)) ? (a) : (b))
#define max(a, b) (((a) > (b)) ? (a) : (b))
#endif
#define near
#define far
#define small char
#define hyper __int64
#define interface struct
#define pascal
#define cdecl
#define IN
#define OUT
#define OPTIONAL
#define CONST const
#define VOID void
#define TRUE 1
#define FALSE 0
#define ERROR 0
#define NO_ERROR 0
#define DELETE 0x10000
#define DIFFERENCE 11
#define STRICT 1
#define IGNORE 0
#define INFINITE 0xffffffff
#define DOMAIN 1
#define OVERFLOW 3
#define UNDERFLOW 4
#define RELATIVE 2
#define ABSOLUTE 1
#define TRANSPARENT 1
#define OPAQUE 2
#define PASSTHROUGH 19
#define rad1 0x490
#define grp1 0x430
#define Yield()
