// Counts the heap and lock calls of each thread in a process that preloads this library. The tests thereby check the
// shipped product, instead of a special build, for allocations and locks in the cycle. Locks are all calls that can
// wait for another thread or wake one: mutexes (tried ones, too), condition variables, reader-writer and spin locks,
// semaphores.
//
// heap_guard_plant_in_loop() plants a call in every second period of each thread that sleeps with clock_nanosleep(), as
// the loop does: the tests show thereby that they would find it.
//
// The counting does not allocate: it uses a fixed table with one row per thread, found through thread-local storage.
#include <dlfcn.h>
#include <pthread.h>
#include <semaphore.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <ctime>

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
std::atomic<int> planted{0};
__thread Row* mine __attribute__((tls_model("initial-exec"))) = nullptr;

Row& row() {
  if (mine == nullptr) {
    const int i = used.fetch_add(1);
    mine = &rows[i < kRows ? i : kRows - 1];
    mine->thread.store(syscall(SYS_gettid));
  }
  return *mine;
}

void* next(const char* name) {
  static void* const library = dlopen("libc.so.6", RTLD_LAZY | RTLD_NOLOAD);
  void* const found = dlsym(library, name);  // RTLD_NEXT would find the oldest version of the condition variables
  return found != nullptr ? found : dlsym(RTLD_NEXT, name);
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
// A function of the C library that is counted as a lock and then called.
#define COUNTED(name, parameters, arguments)                                   \
  int name parameters {                                                        \
    static const auto real = reinterpret_cast<int(*) parameters>(next(#name)); \
    count(&Row::locks);                                                        \
    return real arguments;                                                     \
  }
COUNTED(pthread_mutex_lock, (pthread_mutex_t * m), (m))
COUNTED(pthread_mutex_trylock, (pthread_mutex_t * m), (m))
COUNTED(pthread_mutex_timedlock, (pthread_mutex_t * m, const timespec* t), (m, t))
COUNTED(pthread_mutex_clocklock, (pthread_mutex_t * m, clockid_t clock, const timespec* t), (m, clock, t))
COUNTED(pthread_cond_wait, (pthread_cond_t * c, pthread_mutex_t* m), (c, m))
COUNTED(pthread_cond_timedwait, (pthread_cond_t * c, pthread_mutex_t* m, const timespec* t), (c, m, t))
COUNTED(pthread_cond_clockwait, (pthread_cond_t * c, pthread_mutex_t* m, clockid_t k, const timespec* t), (c, m, k, t))
COUNTED(pthread_cond_signal, (pthread_cond_t * c), (c))
COUNTED(pthread_cond_broadcast, (pthread_cond_t * c), (c))
COUNTED(pthread_rwlock_rdlock, (pthread_rwlock_t * l), (l))
COUNTED(pthread_rwlock_tryrdlock, (pthread_rwlock_t * l), (l))
COUNTED(pthread_rwlock_wrlock, (pthread_rwlock_t * l), (l))
COUNTED(pthread_rwlock_trywrlock, (pthread_rwlock_t * l), (l))
COUNTED(pthread_spin_lock, (pthread_spinlock_t * l), (l))
COUNTED(pthread_spin_trylock, (pthread_spinlock_t * l), (l))
COUNTED(sem_wait, (sem_t * s), (s))
COUNTED(sem_trywait, (sem_t * s), (s))
COUNTED(sem_timedwait, (sem_t * s, const timespec* t), (s, t))
COUNTED(sem_post, (sem_t * s), (s))

/// Makes one call in the calling thread, of the kind 1: allocation, 2: lock, 3: tried lock, 4: signal to a condition
/// variable, 5: system call. Other kinds: none.
void heap_guard_plant(int kind) {
  static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
  static pthread_cond_t condition = PTHREAD_COND_INITIALIZER;
  if (kind == 1) {
    void* volatile memory = malloc(16);
    free(memory);
  }
  if (kind == 2) pthread_mutex_lock(&mutex), pthread_mutex_unlock(&mutex);
  if (kind == 3 && pthread_mutex_trylock(&mutex) == 0) pthread_mutex_unlock(&mutex);
  if (kind == 4) pthread_cond_signal(&condition);
  if (kind == 5) (void)syscall(SYS_getppid);
}

/// From now on plants a call of this kind (0: none) in every second period of the loop.
void heap_guard_plant_in_loop(int kind) { planted.store(kind); }

int clock_nanosleep(clockid_t clock, int flags, const timespec* until, timespec* rest) {
  static const auto real =
      reinterpret_cast<int (*)(clockid_t, int, const timespec*, timespec*)>(next("clock_nanosleep"));
  static thread_local long calls = 0;  // shared, two loops in step would leave all calls to one of them
  if (calls++ % 2 == 0) heap_guard_plant(planted.load());
  return real(clock, flags, until, rest);
}
}
