#include "support/allocation_guard.hpp"

#include <cstddef>

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#include <cerrno>
#endif

namespace {

thread_local long requests = 0;  // trivial type: its own storage is static, so that counting does not allocate

}  // namespace

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)

// A sanitizer owns malloc already: it offers hooks. Its header is not in every compiler's package, so they are declared here.
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*allocated)(const volatile void* memory,
                                                                           std::size_t size),
                                                         void (*freed)(const volatile void* memory));

namespace {

void count_request(const volatile void* /*memory*/, std::size_t /*size*/) { ++requests; }
void ignore_free(const volatile void* /*memory*/) {}
const int hooks_installed = __sanitizer_install_malloc_and_free_hooks(count_request, ignore_free);

}  // namespace

#else

// Every name by which memory is asked for ends here: a program's definitions come before the C library's, also for the shared
// libraries that it loads (operator new calls malloc). The real work is done by glibc's own second names.
extern "C" {

void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* memory, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);

void* malloc(std::size_t size) {
  ++requests;
  return __libc_malloc(size);
}

void* calloc(std::size_t count, std::size_t size) {
  ++requests;
  return __libc_calloc(count, size);
}

void* realloc(void* memory, std::size_t size) {
  ++requests;
  return __libc_realloc(memory, size);
}

void* memalign(std::size_t alignment, std::size_t size) {
  ++requests;
  return __libc_memalign(alignment, size);
}

void* aligned_alloc(std::size_t alignment, std::size_t size) { return memalign(alignment, size); }

int posix_memalign(void** out, std::size_t alignment, std::size_t size) {
  *out = memalign(alignment, size);
  return *out == nullptr ? ENOMEM : 0;
}

}  // extern "C"

#endif

namespace glenoid::test {

AllocationGuard::AllocationGuard() noexcept : before_(requests) {}
AllocationGuard::~AllocationGuard() = default;
long AllocationGuard::allocations() const noexcept { return requests - before_; }

}  // namespace glenoid::test
