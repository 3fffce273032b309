// Part of the ELF libraries that zig links, and of no other.
//
// zig links shared libraries without crtbeginS.o, whose destructor runs the destructors of static objects when a library is
// unloaded. Without it they stay registered with the C library and run at the end of the process, in memory that an importer
// has unmapped by then: a crash after a perfect simulation. This file is that destructor.

extern "C" {
extern void* __dso_handle __attribute__((visibility("hidden")));  // its address identifies this library
void __cxa_finalize(void* library);                               // Itanium C++ ABI 3.3.6.3
}

namespace {

__attribute__((destructor)) void destroy_static_objects() { __cxa_finalize(&__dso_handle); }

}  // namespace
