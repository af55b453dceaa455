// Counts the system calls of one thread of another process, by ptrace: syscall_watch THREAD SECONDS prints the numbers
// of the calls and how often each was made, one pair a line. The thread runs on.
#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <map>

namespace {

constexpr int kSystemCall = SIGTRAP | 0x80;  // stop signal of PTRACE_O_TRACESYSGOOD

/// Number of the system call at whose entry the thread stopped; -1 at an exit.
long entered(pid_t thread) {
  __ptrace_syscall_info info{};
  const long size = ptrace(PTRACE_GET_SYSCALL_INFO, thread, sizeof(info), &info);
  return size > 0 && info.op == PTRACE_SYSCALL_INFO_ENTRY ? static_cast<long>(info.entry.nr) : -1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const pid_t thread = std::atoi(argv[1]);
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(std::atof(argv[2]));
  if (ptrace(PTRACE_SEIZE, thread, 0, PTRACE_O_TRACESYSGOOD) != 0) return std::perror("ptrace"), 3;
  ptrace(PTRACE_INTERRUPT, thread, 0, 0);
  std::map<long, long> calls;
  int status = 0;
  while (waitpid(thread, &status, __WALL) == thread && WIFSTOPPED(status)) {
    const int signal = WSTOPSIG(status);
    if (signal == kSystemCall) {
      if (const long number = entered(thread); number >= 0) ++calls[number];
    }
    if (std::chrono::steady_clock::now() > end) {
      ptrace(PTRACE_DETACH, thread, 0, 0);
      break;
    }
    const bool passes_on = signal != kSystemCall && status >> 16 == 0;
    ptrace(PTRACE_SYSCALL, thread, 0, passes_on ? signal : 0);
  }
  for (const auto& [number, n] : calls) std::printf("%ld %ld\n", number, n);
}
