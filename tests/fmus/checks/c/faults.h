/* A fault of the FMU, chosen by the word in resources/fault.txt; without the file the FMU is correct. */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static char fault[64];

static void read_fault(const char *resources) {
    char path[4096];
    const char *folder = resources && strncmp(resources, "file://", 7) == 0 ? resources + 7 : resources;
    fault[0] = 0;
    snprintf(path, sizeof path, "%s/fault.txt", folder ? folder : ".");
    FILE *file = fopen(path, "r");
    if (!file) return;
    if (fscanf(file, "%63s", fault) != 1) fault[0] = 0;
    fclose(file);
}

static int is(const char *name) { return strcmp(fault, name) == 0; }

static void hang(void) { for (volatile int i = 1; i; ) usleep(1000); }

static void crash(void) { raise(SIGSEGV); }

/* Faults that are the same in whatever function they happen: `at` is the function's part of the name. */
static void misbehave(const char *at) {
    char name[64];
#define CASE(kind, action) snprintf(name, sizeof name, "%s_%s", kind, at); if (is(name)) { action; }
    CASE("crash", crash())
    CASE("abort", abort())
    CASE("exit", _exit(3))
    CASE("hang", hang())
    CASE("memory", for (;;) memset(malloc(1 << 24), 1, 1 << 24))
    CASE("file", FILE *f = fopen("large", "w"); static char z[1 << 20]; for (;;) fwrite(z, 1, sizeof z, f))
    CASE("fork", if (!fork()) { setsid(); hang(); })
    CASE("forkhang", if (!fork()) { setsid(); hang(); } hang())
    CASE("orphan", if (!fork()) { setsid(); if (!fork()) hang(); _exit(0); })
    CASE("killwatcher", kill(getppid(), SIGKILL); hang())
}
