"""Error against run time of several methods on stiff and extreme landings.

    cases/        families of landings with one parameter each
    build         robots of the families
    reference     the proven answer, and the package's path in double precision
    system        what a method is given
    methods       the methods: the package, numpy, Pinocchio
    mujoco_peer   landing simulated in MuJoCo, and the impulsive equation with its matrices
    measure       error and run time of every method on a case
    throughput    many postures against Pinocchio and MuJoCo
    sweeps        rows of sweeps, in one process and in two
    costs         run time of an analysis and of the command
    report        chart, tables, Markdown and CSV
    run           the suite, and one landing of one's own

Nothing else in the package but the command line imports it.
"""
