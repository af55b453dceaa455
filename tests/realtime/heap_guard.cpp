// Counts the heap and lock calls of each thread in a process that preloads this library. The tests thereby check the
// shipped product, instead of a special build, for allocations and locks in the cycle.
//
// The counting does not allocate: it uses a fixed table with one row per thread, found through thread-local storage.
#include <dlfcn.h>
#include <pthread.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdlib>

extern "C" {
void* __libc_malloc(size_t);
void __libc_free(void*);
void* __libc_realloc(void*, size_t);
void* __libc_calloc(size_t, size_t);
void* __libc_memalign(size_t, size_t);
}

namespace {

struct Row {
  std::atomic<long> thread{0}, allocations{0}, releases{0}, locks{0};
};

constexpr int kRows = 4096;
Row rows[kRows];
std::atomic<int> used{0};
__thread Row* mine __attribute__((tls_model("initial-exec"))) = nullptr;

Row& row() {
  if (mine == nullptr) {
    const int i = used.fetch_add(1);
    mine = &rows[i < kRows ? i : kRows - 1];
    mine->thread.store(syscall(SYS_gettid));
  }
  return *mine;
}

void count(std::atomic<long> Row::* what) { (row().*what).fetch_add(1, std::memory_order_relaxed); }

}  // namespace

extern "C" {

/// Counts of the thread with this kernel id: allocations, releases, locks; -1 if the thread has made no such call.
void heap_guard_read(long thread, long out[3]) {
  out[0] = out[1] = out[2] = -1;
  for (int i = 0; i < kRows && i < used.load(); ++i) {
    if (rows[i].thread.load() == thread) {
      out[0] = rows[i].allocations.load();
      out[1] = rows[i].releases.load();
      out[2] = rows[i].locks.load();
    }
  }
}

void* malloc(size_t n) {
  count(&Row::allocations);
  return __libc_malloc(n);
}
void* calloc(size_t n, size_t size) {
  count(&Row::allocations);
  return __libc_calloc(n, size);
}
void* realloc(void* p, size_t n) {
  count(&Row::allocations);
  return __libc_realloc(p, n);
}
void* memalign(size_t alignment, size_t n) {
  count(&Row::allocations);
  return __libc_memalign(alignment, n);
}
void* aligned_alloc(size_t alignment, size_t n) { return memalign(alignment, n); }
int posix_memalign(void** out, size_t alignment, size_t n) {
  *out = memalign(alignment, n);
  return *out == nullptr ? ENOMEM : 0;
}
void free(void* p) {
  if (p != nullptr) {
    count(&Row::releases);
    __libc_free(p);
  }
}
int pthread_mutex_lock(pthread_mutex_t* mutex) {
  using Lock = int (*)(pthread_mutex_t*);
  static const Lock real = reinterpret_cast<Lock>(dlsym(RTLD_NEXT, "pthread_mutex_lock"));
  count(&Row::locks);
  return real(mutex);
}
}
