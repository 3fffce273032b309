// Part of the x86_64 ELF libraries that zig links, and of no other.
//
// Functions with target_clones ask the compiler's run-time library which instructions the processor has. In zig that library
// is one object, which also defines sin, cos, exp and others: asking it would replace those of the C library, and the FMU
// would no longer give the bits of the core. So the question is answered here, for the one feature that the core asks about.
// Layout and numbers are those of GCC's and LLVM's cpuinfo.
#include <cpuid.h>

namespace {

constexpr unsigned kFeatureAvx2 = 10;  // FEATURE_AVX2

/// The processor has AVX2 and the operating system saves its registers.
bool has_avx2() noexcept {
  unsigned a = 0, b = 0, c = 0, d = 0;
  constexpr unsigned kAvxAndOsxsave = bit_AVX | bit_OSXSAVE;
  if (__get_cpuid(1, &a, &b, &c, &d) == 0 || (c & kAvxAndOsxsave) != kAvxAndOsxsave) return false;
  unsigned low = 0, high = 0;
  __asm__("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
  constexpr unsigned kSseAndAvxState = 6;
  if ((low & kSseAndAvxState) != kSseAndAvxState) return false;
  return __get_cpuid_count(7, 0, &a, &b, &c, &d) != 0 && (b & bit_AVX2) != 0;
}

}  // namespace

extern "C" {

struct CpuModel {
  unsigned vendor, type, subtype, features[1];
};
__attribute__((visibility("hidden"))) CpuModel __cpu_model = {0, 0, 0, {0}};
__attribute__((visibility("hidden"))) unsigned __cpu_features2[4] = {0, 0, 0, 0};

/// Called by the resolvers while the library is being loaded, before any constructor.
__attribute__((visibility("hidden"))) int __cpu_indicator_init() {
  __cpu_model.features[0] = has_avx2() ? 1U << kFeatureAvx2 : 0U;
  return 0;
}

}  // extern "C"
