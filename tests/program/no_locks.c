/* A file system without locks, for programs that are started with this library before the others: below the folder in NO_LOCKS_BELOW
 * flock answers with the error in NO_LOCKS_ERROR. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

int flock(int file, int operation)
{
    char link[64], path[PATH_MAX + 1];
    const char *below = getenv("NO_LOCKS_BELOW"), *error = getenv("NO_LOCKS_ERROR");
    snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    ssize_t length = readlink(link, path, PATH_MAX);
    if (length > 0 && below && error && (size_t)length > strlen(below) && !strncmp(path, below, strlen(below))) {
        errno = atoi(error);
        return -1;
    }
    int (*next)(int, int) = (int (*)(int, int))dlsym(RTLD_NEXT, "flock");
    return next(file, operation);
}
