// What ROS says went wrong, in words.
#pragma once

#include <rcl/error_handling.h>
#include <rcl/types.h>

#include <stdexcept>
#include <string>

namespace palpate::ros {

/// While something is set up; at run time a call answers with a Status instead.
struct Error : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Answer of a call at run time: empty when it did what it was asked for.
struct [[nodiscard]] Status {
  std::string problem;
  explicit operator bool() const noexcept { return problem.empty(); }
};

/// The words of the last call that failed in this thread, which are taken away with it.
[[nodiscard]] inline std::string last_words() {
  const std::string words = rcl_get_error_string().str;
  rcl_reset_error();
  return words;
}

[[nodiscard]] inline Status status(rcl_ret_t answer, const std::string& wish) {
  if (answer == RCL_RET_OK) return {};
  return {"cannot " + wish + ": " + last_words()};
}

inline void check(rcl_ret_t answer, const std::string& wish) {
  if (const Status done = status(answer, wish); !done) throw Error(done.problem);
}

}  // namespace palpate::ros
