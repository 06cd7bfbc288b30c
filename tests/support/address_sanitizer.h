/// @file
/// LEADLINE_ADDRESS_SANITIZER: 1 under the address sanitizer, which has a malloc of its own; else 0.
#pragma once

#if defined(__SANITIZE_ADDRESS__)
#define LEADLINE_ADDRESS_SANITIZER 1
#elif defined(__has_feature)
#define LEADLINE_ADDRESS_SANITIZER __has_feature(address_sanitizer)
#else
#define LEADLINE_ADDRESS_SANITIZER 0
#endif
