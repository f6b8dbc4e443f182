/* Controllers of your own in C: the program of an agent for `slipstream run --agent NAME=PROGRAM`.
 *
 *     cargo build --release -p slipstream-c
 *     cc my_agent.c -o my_agent -I agents/c -L target/release -lslipstream_c -Wl,-rpath,target/release -lm
 *
 * Times are in seconds of the run. Poses are x (m), y (m), phi (rad) of the centre of mass c; velocities are v (m/s),
 * w (rad/s); pairs of wheels are right, left. Robots are counted from 0: robot 0 is r1. */

#ifndef SLIPSTREAM_H
#define SLIPSTREAM_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Largest number of numbers that a controller adds to its messages. */
#define SLIPSTREAM_MAX_EXTRA 8

/* The newest message of another robot. */
typedef struct slipstream_heard {
    uint32_t robot;
    uint32_t extra_count;                  /* how many of `extra` there are */
    double pose[3];                        /* by its odometry */
    double velocity[2];                    /* its reference velocity */
    double extra[SLIPSTREAM_MAX_EXTRA];    /* of its controller */
    double sampled_s;                      /* when the encoders behind the pose were read */
    double sent_s;                         /* when it was sent */
    double taken_s;                        /* the outer tick at which it came out of the link */
    bool fresh;                            /* whether it came at this tick */
} slipstream_heard;

/* What is known at an outer tick. */
typedef struct slipstream_outer_input {
    double t_s;
    double period_s;                       /* since the last outer tick */
    double pose[3];                        /* by odometry */
    double velocity[2];                    /* by the wheels */
    double reference[3];                   /* behind the robot ahead on its path, or by the profile */
    double reference_velocity[2];
    double error[3];                       /* e_x (m), e_y (m), e_theta (rad) of the midpoint of the axle */
    double profile[3];                     /* where the robot would be by the profile alone */
    double profile_velocity[2];
    const slipstream_heard *heard;         /* in the order of the robots */
    uint32_t heard_count;
    bool coordinates;                      /* whether coordination has begun */
} slipstream_outer_input;

/* What is known at an inner tick. */
typedef struct slipstream_inner_input {
    double t_s;
    double period_s;                       /* since the last inner tick */
    double wheel_speed_rad_s[2];
    double velocity[2];                    /* by these */
    double desired[2];                     /* v, w that the outer loop asks for */
    double set_point_rad_s[2];             /* the wheel speeds for them */
    double limit_nm[2];                    /* torque limits */
    double friction;                       /* behind the limits; 0 if they do not follow from friction */
    bool brakes;                           /* whether the watchdog brakes */
} slipstream_inner_input;

/* A controller. What its functions get is valid until they return. A function that does not return 0 ends the run. */
typedef struct slipstream_controller {
    void *state;
    /* Desired v (m/s), w (rad/s). */
    int (*outer)(void *state, const slipstream_outer_input *now, double desired[2]);
    /* Torques (N m), cut to the limits. They come with those of the paper's speed loops, which advance at every tick. NULL: these. */
    int (*inner)(void *state, const slipstream_inner_input *now, double torque_nm[2]);
    /* Numbers that go out with the robot's position; returns how many. Asked for after `outer`. NULL: none. */
    uint32_t (*message)(void *state, double extra[SLIPSTREAM_MAX_EXTRA]);
} slipstream_controller;

/* What is known when a controller is made. */
typedef struct slipstream_context slipstream_context;

/* The robot. */
uint32_t slipstream_robot(const slipstream_context *context);

/* The parameter controller.NAME.`name` of the experiment; `otherwise` if it gives none. */
double slipstream_number(const slipstream_context *context, const char *name, double otherwise);

/* Runs the agent that the arguments of main name, with the controller that `make` fills in; returns the exit code of main.
 * `make` returns 0, or anything else if there can be no controller. */
int slipstream_run_agent(int argc, char **argv, int (*make)(const slipstream_context *context, slipstream_controller *controller));

#ifdef __cplusplus
}
#endif

#endif
