/// @file
/// LEADLINE_ADDRESS_SANITIZER: 1 under the address sanitizer, which has a malloc of its own; else 0.
#pragma once

#if defined(__SANITIZE_ADDRESS__)  // GCC
#define LEADLINE_ADDRESS_SANITIZER 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)  // Clang
#define LEADLINE_ADDRESS_SANITIZER 1
#endif
#endif
#ifndef LEADLINE_ADDRESS_SANITIZER
#define LEADLINE_ADDRESS_SANITIZER 0
#endif
