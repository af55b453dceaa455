// Errors of ROS calls, with the error text of rcl.
#pragma once

#include <rcl/error_handling.h>
#include <rcl/types.h>

#include <stdexcept>
#include <string>

namespace palpate::ros {

/// Error during construction; at run time calls return a Status instead.
struct Error : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Result of a call at run time: `problem` is empty on success.
struct [[nodiscard]] Status {
  std::string problem;
  explicit operator bool() const noexcept { return problem.empty(); }
};

/// Error text of the last failed call in this thread; also resets the error state of rcl.
[[nodiscard]] inline std::string last_words() {
  const std::string words = rcl_get_error_string().str;
  rcl_reset_error();
  return words;
}

/// Status of a call from its return code. `wish`: the action, as in "cannot publish /topic: ...".
[[nodiscard]] inline Status status(rcl_ret_t answer, const std::string& wish) {
  if (answer == RCL_RET_OK) return {};
  return {"cannot " + wish + ": " + last_words()};
}

/// Throws Error if a call has failed.
inline void check(rcl_ret_t answer, const std::string& wish) {
  if (const Status done = status(answer, wish); !done) throw Error(done.problem);
}

}  // namespace palpate::ros
