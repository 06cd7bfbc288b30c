/// @file
/// LEADLINE_SANITIZER: 1 under the address and the thread sanitizer, which have a malloc of their own; else
/// 0.
#pragma once

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)  // GCC
#define LEADLINE_SANITIZER 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)  // Clang
#define LEADLINE_SANITIZER 1
#endif
#endif
#ifndef LEADLINE_SANITIZER
#define LEADLINE_SANITIZER 0
#endif
