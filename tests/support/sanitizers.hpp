#pragma once

// __SANITIZE_ADDRESS__ under AddressSanitizer, for clang, too.
#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define __SANITIZE_ADDRESS__ 1  // as g++ says it
#endif
#endif
