// Included before every source of a Linux build by zig. Its own support library has a sine, a cosine and an exponential that
// differ from glibc's in the last bit; naming glibc's symbol with its version makes the linker take that one, so that the
// FMU computes the same bits as the core.
#if defined(__x86_64__)
__asm__(".symver sin,sin@GLIBC_2.2.5");
__asm__(".symver cos,cos@GLIBC_2.2.5");
__asm__(".symver exp,exp@GLIBC_2.2.5");
#elif defined(__aarch64__)
__asm__(".symver sin,sin@GLIBC_2.17");
__asm__(".symver cos,cos@GLIBC_2.17");
__asm__(".symver exp,exp@GLIBC_2.17");
#endif
