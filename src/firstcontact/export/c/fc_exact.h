/* First in every file of arithmetic: a product and a sum are rounded one by one, as in Python,
   whatever the compiler was told. Arduino's and PlatformIO's options fuse the two where they can,
   and no file of a library can change these; GCC takes it from here for the rest of the file. */
#ifndef FC_EXACT_H
#define FC_EXACT_H

#if defined(__FAST_MATH__)
#error "compile without -ffast-math: what is not a number would pass for one"
#elif defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC optimize("fp-contract=off")
#endif

#endif
