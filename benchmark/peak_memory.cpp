// Runs a program and prints its largest resident memory [kB]:  peak_memory PROGRAM ...
//
// This is a small program of its own, because the count of a child begins with the memory of its
// parent.

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: peak_memory PROGRAM [arguments]\n");
    return EXIT_FAILURE;
  }
  const pid_t child = fork();
  if (child == 0) {
    if (std::freopen("/dev/null", "w", stdout) != nullptr) execv(argv[1], argv + 1);
    _exit(127);
  }
  int status = 0;
  rusage usage = {};
  if (child < 0 || wait4(child, &status, 0, &usage) != child) {
    std::perror("peak_memory");
    return EXIT_FAILURE;
  }
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    std::fprintf(stderr, "peak_memory: %s has failed\n", argv[1]);
    return EXIT_FAILURE;
  }
  std::printf("%ld\n", usage.ru_maxrss);
  return EXIT_SUCCESS;
}
