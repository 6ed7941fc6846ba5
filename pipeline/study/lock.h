#pragma once
#include <atomic>
#include <filesystem>
#include <functional>

namespace beatlas::study {

/// Held while a program writes into a folder; others wait for it. It ends with the process,
/// however that ends. Where the file system knows no locks there is none.
class Lock {
 public:
  /// Waits until the folder is free.
  /// @param waiting called once if another program holds it; may be empty
  /// @param cancel looked at while waiting; may be null
  /// @throws Error{Machine} if the folder cannot be opened, or if cancelled
  Lock(const std::filesystem::path& folder, const std::function<void()>& waiting,
       const std::atomic<bool>* cancel);
  ~Lock();
  Lock(const Lock&) = delete;
  Lock& operator=(const Lock&) = delete;

  /// Whether another program holds the folder now.
  [[nodiscard]] static bool held(const std::filesystem::path& folder);

 private:
  int descriptor_ = -1;
};

}  // namespace beatlas::study
