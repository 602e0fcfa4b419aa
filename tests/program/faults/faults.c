// A disk that fails: loaded into a program before all other libraries (LD_PRELOAD), it lets one of the program's accesses to the files of
// one folder fail, or all from that one on. Accesses are counted from 1, in the order in which they happen.
//
//   FAULTS_FOLDER  the folder, an absolute path without symbolic links
//   FAULTS_AT      which access fails; 0: none does, and the log has all of them
//   FAULTS_KIND    io: that one fails with EIO; full: all that need room fail from there on with ENOSPC, the first write half-way
//   FAULTS_LOG     a file outside the folder: which accesses failed, a line each

#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
static long accesses;

static int is_inside(const char *path) {
    const char *folder = getenv("FAULTS_FOLDER");
    size_t length = folder ? strlen(folder) : 0;
    return length && path && !strncmp(path, folder, length) && (path[length] == '/' || !path[length]);
}

static void report(const char *what, const char *path) {
    char line[PATH_MAX + 64];
    int length = snprintf(line, sizeof line, "%s %s\n", what, path);
    int log = REAL(open)(getenv("FAULTS_LOG"), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
    if (log < 0 || REAL(write)(log, line, length) != length) abort();
    close(log);
}

enum { PASSES, FAILS, FAILS_HALF_WAY };

// What becomes of an access; `needs_room` if a full disk is a reason to fail.
static int fate(const char *what, const char *path, int needs_room) {
    if (!is_inside(path)) return PASSES;
    const char *kind = getenv("FAULTS_KIND");
    int full = kind && !strcmp(kind, "full");
    if (full && !needs_room) return PASSES;
    long at = atol(getenv("FAULTS_AT"));
    pthread_mutex_lock(&mutex);
    long number = ++accesses;
    pthread_mutex_unlock(&mutex);
    if (at == 0) {
        report(what, path);
        return PASSES;
    }
    if (number < at || (number > at && !full)) return PASSES;
    report(what, path);
    errno = full ? ENOSPC : EIO;
    return full && number == at ? FAILS_HALF_WAY : FAILS;
}

static int fate_of_file(const char *what, int file, int needs_room) {
    char link[32], path[PATH_MAX];
    snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    ssize_t length = readlink(link, path, sizeof path - 1);
    if (length < 0) return PASSES;
    path[length] = 0;
    return fate(what, path, needs_room);
}

#define OPEN(name)                                                                      \
    int name(const char *path, int flags, ...) {                                        \
        va_list rest;                                                                   \
        va_start(rest, flags);                                                          \
        mode_t mode = flags & (O_CREAT | O_TMPFILE) ? va_arg(rest, mode_t) : 0;         \
        va_end(rest);                                                                   \
        int creates = flags & O_CREAT;                                                  \
        if (fate(creates ? "create" : "open", path, creates) != PASSES) return -1;      \
        return REAL(name)(path, flags, mode);                                           \
    }
OPEN(open)
OPEN(open64)

ssize_t write(int file, const void *bytes, size_t count) {
    int fate = fate_of_file("write", file, 1);
    if (fate == PASSES) return REAL(write)(file, bytes, count);
    if (fate == FAILS_HALF_WAY && count > 1) return REAL(write)(file, bytes, count / 2);
    return -1;
}

ssize_t read(int file, void *bytes, size_t count) {
    return fate_of_file("read", file, 0) == PASSES ? REAL(read)(file, bytes, count) : -1;
}

int fsync(int file) {
    return fate_of_file("sync", file, 1) == PASSES ? REAL(fsync)(file) : -1;
}

int rename(const char *from, const char *to) {
    return fate("rename", to, 1) == PASSES ? REAL(rename)(from, to) : -1;
}

int mkdir(const char *path, mode_t mode) {
    return fate("make", path, 1) == PASSES ? REAL(mkdir)(path, mode) : -1;
}
