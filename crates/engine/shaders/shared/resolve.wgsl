// Shared by the kernels that sort and blend the lists of one class.
#import lists
#import stop
#import early_end

#push
